#include "bearing_calibration/vision/blob_segmenter.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_ellipse.h"

namespace bearing_calibration::core {
namespace {

// A light is some tens of runs. So many blobs or runs are noise: the threshold lies in the
// background.
constexpr std::size_t kMaxBlobs = 20000;
constexpr std::size_t kMaxRuns = 100000;

constexpr int kBlock = 32;

// Whether a block's levels are all on one side of the threshold. Without branches and of a length
// that the compiler knows, these loops become vector instructions.
template <typename Level>
bool isDark(const Level* levels, Level threshold) {
  Level brightest = 0;
  for (int i = 0; i < kBlock; ++i) brightest = std::max(brightest, levels[i]);
  return brightest <= threshold;
}
template <typename Level>
bool isBright(const Level* levels, Level threshold) {
  Level darkest = std::numeric_limits<Level>::max();
  for (int i = 0; i < kBlock; ++i) darkest = std::min(darkest, levels[i]);
  return darkest > threshold;
}

/// Writes the columns of [begin, end) where runs begin and end, in turn. @return behind the last
template <typename Level>
int* writeEdges(const Level* row, int begin, int end, Level threshold, int* edges) {
  constexpr int kStep = 16;
  bool bright = false;
  for (int u = begin; u < end;) {
    const int block = std::min(u, end - kBlock);  // not beyond the end
    if (block >= 0 &&
        (bright ? isBright(row + block, threshold) : isDark(row + block, threshold))) {
      u += kBlock;
      continue;
    }
    for (const int last = std::min(u + kStep, end); u < last; ++u) {
      const bool is_bright = row[u] > threshold;
      *edges = u;  // the next one's place unless it is one; a branch would cost more
      edges += is_bright != bright ? 1 : 0;
      bright = is_bright;
    }
  }
  if (bright) *edges++ = end;
  return edges;
}

}  // namespace

BlobSegmenter::BlobSegmenter() {
  runs_.reserve(kMaxRuns);
  blobs_.reserve(kMaxBlobs);
}

const std::vector<Blob>& BlobSegmenter::segment(const cv::Mat& image,
                                                const std::vector<PixelStrip>& strips,
                                                int threshold) {
  edges_.resize(static_cast<std::size_t>(image.cols) + 2);
  runs_.clear();
  blobs_.clear();
  complete_ = (image.depth() == CV_8U ? findRuns<std::uint8_t>(image, strips, threshold)
                                      : findRuns<std::uint16_t>(image, strips, threshold)) &&
              join();
  if (complete_) addUp();
  return blobs_;
}

/// The runs of bright pixels in reading order. @return whether there was room for all
template <typename Level>
bool BlobSegmenter::findRuns(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                             int threshold) {
  if (strips.empty()) return true;
  const Level limit = cv::saturate_cast<Level>(threshold);
  const int first_row = strips.front().row;
  const int last_row = strips.back().row;
  for (const PixelStrip& strip : strips) {
    const int* last =
        writeEdges(image.ptr<Level>(strip.row), strip.begin, strip.end, limit, edges_.data());
    for (const int* edge = edges_.data(); edge != last; edge += 2) {
      if (runs_.size() == kMaxRuns) return false;
      const bool cut = edge[0] == strip.begin || edge[1] == strip.end || strip.row == first_row ||
                       strip.row == last_row;
      runs_.push_back({strip.row, edge[0], edge[1], cut, 0, 0});
    }
  }
  return true;
}

/// The run that stands for all that are joined with this one.
std::size_t BlobSegmenter::rootOf(std::size_t run) {
  while (runs_[run].parent != run) {
    runs_[run].parent = runs_[runs_[run].parent].parent;
    run = runs_[run].parent;
  }
  return run;
}

/// Joins runs that touch. @return whether there are no more blobs than a scene has
bool BlobSegmenter::join() {
  std::size_t above = 0;  // the first run that may touch
  std::size_t roots = 0;
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    Run& run = runs_[i];
    const auto isPassed = [&](const Run& other) {
      return other.row < run.row - 1 || (other.row == run.row - 1 && other.end < run.begin);
    };
    while (isPassed(runs_[above])) ++above;
    run.parent = i;
    for (std::size_t j = above; runs_[j].row < run.row && runs_[j].begin <= run.end; ++j) {
      const std::size_t root = rootOf(j);
      if (run.parent == i) run.parent = root;
      runs_[root].parent = run.parent;
    }
    if (run.parent == i && ++roots > kMaxBlobs) return false;
  }
  return true;
}

/// Adds each run's pixels to its root's blob.
void BlobSegmenter::addUp() {
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    if (runs_[i].parent != i) continue;
    runs_[i].blob = blobs_.size();
    blobs_.emplace_back();
  }
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    const Run& run = runs_[i];
    Blob& blob = blobs_[runs_[rootOf(i)].blob];
    const std::int64_t v = run.row;
    const std::int64_t n = run.end - run.begin;
    const std::int64_t twice_middle = run.begin + run.end - 1;
    const std::int64_t sum_u = n * twice_middle / 2;
    blob.pixels += n;
    blob.sum_u += sum_u;
    blob.sum_v += n * v;
    blob.sum_uu += n * (3 * twice_middle * twice_middle + n * n - 1) / 12;
    blob.sum_uv += sum_u * v;
    blob.sum_vv += n * v * v;
    blob.cut = blob.cut || run.cut;
  }
}

BlobShape shapeOf(const Blob& blob) {
  const double n = static_cast<double>(blob.pixels);
  const auto mean = [&](std::int64_t sum) { return static_cast<double>(sum) / n; };
  BlobShape shape;
  shape.centre_px = {mean(blob.sum_u), mean(blob.sum_v)};
  shape.covariance_px2 << mean(blob.sum_uu), mean(blob.sum_uv), mean(blob.sum_uv),
      mean(blob.sum_vv);
  shape.covariance_px2 +=
      kPixelVariance * Eigen::Matrix2d::Identity() - shape.centre_px * shape.centre_px.transpose();
  shape.fill = n / (4.0 * kPi * std::sqrt(shape.covariance_px2.determinant()));
  return shape;
}

}  // namespace bearing_calibration::core
