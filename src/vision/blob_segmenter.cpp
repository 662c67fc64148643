#include "bearing_calibration/vision/blob_segmenter.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/pixel_kernels.h"

namespace bearing_calibration {
namespace {

// A light is some tens of runs. So many blobs or runs are noise: the threshold lies in the
// background.
constexpr std::size_t kMaxLabels = 20000;
constexpr std::size_t kMaxEdges = 200000;

template <typename Level>
ImageRows<Level> rowsOf(const cv::Mat& image) {
  return {image.ptr<Level>(0), static_cast<std::ptrdiff_t>(image.step1()), image.cols};
}

void addTo(Blob* blob, std::int64_t row, std::int64_t begin, std::int64_t end) {
  const std::int64_t pixels = end - begin;
  const std::int64_t twice_middle = begin + end - 1;
  const std::int64_t sum_u = twice_middle * pixels / 2;
  blob->pixels += pixels;
  blob->sum_u += sum_u;
  blob->sum_v += row * pixels;
  blob->sum_uu += pixels * (3 * twice_middle * twice_middle + pixels * pixels - 1) / 12;
  blob->sum_uv += row * sum_u;
  blob->sum_vv += row * row * pixels;
}

void addTo(Blob* blob, const Blob& part) {
  blob->pixels += part.pixels;
  blob->sum_u += part.sum_u;
  blob->sum_v += part.sum_v;
  blob->sum_uu += part.sum_uu;
  blob->sum_uv += part.sum_uv;
  blob->sum_vv += part.sum_vv;
  blob->cut = blob->cut || part.cut;
}

}  // namespace

BlobSegmenter::BlobSegmenter() {
  labels_.reserve(kMaxLabels);
  parents_.reserve(kMaxLabels + 1);
  blobs_.reserve(kMaxLabels + 1);
}

const std::vector<Blob>& BlobSegmenter::segment(const cv::Mat& image,
                                                const std::vector<PixelInterval>& intervals,
                                                int threshold) {
  bright_.resize(intervals.size() + 1);
  ends_.resize(intervals.size());
  edges_.resize(kMaxEdges + static_cast<std::size_t>(image.cols));
  const BrightRuns runs{bright_.data(), ends_.data(), edges_.data(), edges_.size()};
  const BrightCount bright =
      image.depth() == CV_8U
          ? pixelKernels().findRunsOfBytes(rowsOf<std::uint8_t>(image), intervals.data(),
                                           intervals.size(), threshold, runs)
          : pixelKernels().findRunsOfWords(rowsOf<std::uint16_t>(image), intervals.data(),
                                           intervals.size(), threshold, runs);
  parents_.clear();
  blobs_.clear();
  complete_ = join(intervals, bright.intervals) && bright.complete;
  collect();
  return blobs_;
}

/// The first of a label's chain.
inline int BlobSegmenter::root(int label) {
  while (parents_[static_cast<std::size_t>(label)] != label) {
    int& parent = parents_[static_cast<std::size_t>(label)];
    parent = parents_[static_cast<std::size_t>(parent)];
    label = parent;
  }
  return label;
}

/// The label of the runs above that touch [begin, end), which become one; a new one without any.
inline int BlobSegmenter::labelOf(int begin, int end, RunRange* above) {
  const int* edges = edges_.data();
  while (above->first < above->last && edges[2 * above->first + 1] < begin) ++above->first;
  int label = kNoLabel;
  for (std::size_t run = above->first; run < above->last && edges[2 * run] <= end; ++run) {
    const int joined = root(labels_[run]);
    if (label == kNoLabel) label = joined;
    parents_[static_cast<std::size_t>(joined)] = label;
  }
  if (label != kNoLabel) return label;
  parents_.push_back(static_cast<int>(parents_.size()));
  blobs_.emplace_back();
  return parents_.back();
}

/// Sums up runs that touch under one label, or under labels of one root. @return whether there were
/// enough labels
bool BlobSegmenter::join(const std::vector<PixelInterval>& intervals, std::size_t bright) {
  if (bright == 0) return true;
  labels_.resize(static_cast<std::size_t>(ends_[bright - 1]) / 2);
  RunRange above;
  std::size_t row_begin = 0;
  std::size_t run = 0;
  int row = intervals[bright_[0]].row;
  const int first_row = intervals.front().row;
  const int last_row = intervals.back().row;
  int owner = kNoLabel;
  Blob blob;  // the owner's, which gets most of the runs
  for (std::size_t i = 0; i < bright; ++i) {
    const PixelInterval interval = intervals[bright_[i]];
    if (interval.row != row) {
      above = {interval.row == row + 1 ? row_begin : run, run};
      row_begin = run;
      row = interval.row;
    }
    for (const std::size_t last = static_cast<std::size_t>(ends_[i]) / 2; run < last; ++run) {
      const int begin = edges_[2 * run];
      const int end = edges_[2 * run + 1];
      const int label = labelOf(begin, end, &above);
      labels_[run] = label;
      if (label != owner) {
        if (owner != kNoLabel) blobs_[static_cast<std::size_t>(owner)] = blob;
        if (blobs_.size() > kMaxLabels) return false;
        owner = label;
        blob = blobs_[static_cast<std::size_t>(owner)];
      }
      addTo(&blob, row, begin, end);
      blob.cut |=
          begin == interval.begin || end == interval.end || row == first_row || row == last_row;
    }
  }
  if (owner != kNoLabel) blobs_[static_cast<std::size_t>(owner)] = blob;
  return true;
}

/// Leaves the roots' blobs, with what belongs to them.
void BlobSegmenter::collect() {
  std::size_t roots = 0;
  for (std::size_t label = 0; label < blobs_.size(); ++label) {
    const auto owner = static_cast<std::size_t>(root(static_cast<int>(label)));
    if (owner != label) addTo(&blobs_[owner], blobs_[label]);
  }
  for (std::size_t label = 0; label < blobs_.size(); ++label) {
    if (parents_[label] == static_cast<int>(label)) blobs_[roots++] = blobs_[label];
  }
  blobs_.resize(roots);
}

BlobShape shapeOf(const Blob& blob) {
  constexpr double kPixelVariance = 1.0 / 12.0;  // of a square of side 1
  const double n = static_cast<double>(blob.pixels);
  const double u = static_cast<double>(blob.sum_u) / n;
  const double v = static_cast<double>(blob.sum_v) / n;
  BlobShape shape{u, v, 0.0, 0.0, 0.0, 0.0};
  shape.variance_uu_px2 = static_cast<double>(blob.sum_uu) / n - u * u + kPixelVariance;
  shape.variance_uv_px2 = static_cast<double>(blob.sum_uv) / n - u * v;
  shape.variance_vv_px2 = static_cast<double>(blob.sum_vv) / n - v * v + kPixelVariance;
  const double det =
      shape.variance_uu_px2 * shape.variance_vv_px2 - shape.variance_uv_px2 * shape.variance_uv_px2;
  shape.fill = n / (4.0 * kPi * std::sqrt(det));
  return shape;
}

}  // namespace bearing_calibration
