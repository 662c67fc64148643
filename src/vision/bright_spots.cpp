#include "bearing_calibration/vision/bright_spots.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// The grid's step along columns and rows: some three thousand samples of a 640x480 image, a
/// hundred and fifty of a sector of +-10 degrees, a hundred of the patch around a light are enough
/// for a quantile to a tenth of the spread. Steps that share no factor with the blocks of 8 pixels
/// of JPEG.
cv::Size gridFor(int rows) {
  constexpr int kFewRows = 40;
  constexpr int kSomeRows = 100;
  if (rows < kFewRows) return {5, 3};
  return rows < kSomeRows ? cv::Size(7, 7) : cv::Size(9, 7);
}

/// How often each level was sampled.
class Histogram {
 public:
  Histogram(const cv::Mat& image, const std::vector<PixelStrip>& strips, double max_level) {
    while (static_cast<std::size_t>(max_level) >> shift_ >= counts_.size()) ++shift_;
    last_bin_ = static_cast<int>(max_level) >> shift_;
    const bool eight_bits = image.depth() == CV_8U;
    const cv::Size grid = gridFor(strips.back().row - strips.front().row + 1);
    for (const PixelStrip& strip : strips) {
      if (strip.row % grid.height != 0) continue;
      for (int u = strip.begin; u < strip.end; u += grid.width) {
        const int level = eight_bits ? image.ptr<std::uint8_t>(strip.row)[u]
                                     : image.ptr<std::uint16_t>(strip.row)[u];
        ++counts_[static_cast<std::size_t>(std::min(level >> shift_, last_bin_))];
        ++samples_;
      }
    }
  }

  /// The level with this part of the samples below it.
  double quantile(double part) const {
    const double wanted = part * samples_;
    const double levels_per_bin = static_cast<double>(1U << shift_);
    int seen = 0;
    for (int bin = 0; bin <= last_bin_; ++bin) {
      const int here = counts_[static_cast<std::size_t>(bin)];
      // Levels are integers: within a bin the samples are taken as spread evenly about its middle.
      if (here > 0 && seen + here >= wanted) {
        return levels_per_bin * (bin + (wanted - seen) / here) - 0.5;
      }
      seen += here;
    }
    return 0.0;
  }

 private:
  int shift_ = 0;  ///< a level is in bin level >> shift_
  int last_bin_;
  int samples_ = 0;
  std::array<int, 1024> counts_{};
};

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

BackgroundLevel backgroundOf(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                             double max_level) {
  constexpr double kOneSigmaBelow = 0.1587;  // of a normal distribution
  if (strips.empty()) return {};
  const Histogram histogram(image, strips, max_level);
  const double median = histogram.quantile(0.5);
  return {median, median - histogram.quantile(kOneSigmaBelow)};
}

Thresholds thresholdsOver(const BackgroundLevel& background, const ThresholdConfig& config,
                          const ImageSensor& sensor) {
  // The last one lies where a textured background still shows no blobs of a light's size.
  constexpr double kLowerPart = 0.5;
  const double highest = sensor.saturation_level - 1.0;  // what is full is always seen
  const auto above = [&](double spreads) {
    const double contrast = std::max(config.min_contrast_levels, spreads * background.spread);
    return std::min(background.median + contrast, highest);
  };
  const double first = above(config.spreads);
  Thresholds thresholds;
  const int rises = static_cast<int>(thresholds.size()) - 2;
  for (int step = 0; step <= rises; ++step) {
    thresholds[static_cast<std::size_t>(step)] =
        static_cast<int>(first + (highest - first) * step / rises);
  }
  thresholds.back() = static_cast<int>(above(kLowerPart * config.spreads));
  return thresholds;
}

const std::vector<Blob>& BlobSegmenter::segment(const cv::Mat& image,
                                                const std::vector<PixelStrip>& strips,
                                                int threshold, int least_pixels) {
  edges_.resize(static_cast<std::size_t>(image.cols) + 2);
  runs_.clear();
  blobs_.clear();
  complete_ = (image.depth() == CV_8U ? findRuns<std::uint8_t>(image, strips, threshold)
                                      : findRuns<std::uint16_t>(image, strips, threshold)) &&
              join();
  if (complete_) addUp(least_pixels);
  return blobs_;
}

/// The runs of bright pixels in reading order. @return whether there was room for all
template <typename Level>
bool BlobSegmenter::findRuns(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                             int threshold) {
  const Level limit = cv::saturate_cast<Level>(threshold);
  for (const PixelStrip& strip : strips) {
    const bool is_border = strip.row == strips.front().row || strip.row == strips.back().row;
    const int* last =
        writeEdges(image.ptr<Level>(strip.row), strip.begin, strip.end, limit, edges_.data());
    for (const int* edge = edges_.data(); edge != last; edge += 2) {
      if (runs_.size() == kMaxRuns) return false;
      const bool cut = is_border || edge[0] == strip.begin || edge[1] == strip.end;
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

/// Adds each run's pixels to its root's blob, and leaves out the specks.
void BlobSegmenter::addUp(int least_pixels) {
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
  const auto is_speck = [=](const Blob& blob) { return blob.pixels < least_pixels; };
  blobs_.erase(std::remove_if(blobs_.begin(), blobs_.end(), is_speck), blobs_.end());
}

LightEllipse ellipseOf(const Blob& blob, const Eigen::Vector2d& mirror_centre_px) {
  const double n = static_cast<double>(blob.pixels);
  const auto mean = [&](std::int64_t sum) { return static_cast<double>(sum) / n; };
  LightEllipse ellipse;
  ellipse.centre_px = {mean(blob.sum_u), mean(blob.sum_v)};
  Eigen::Matrix2d squares;
  squares << mean(blob.sum_uu), mean(blob.sum_uv), mean(blob.sum_uv), mean(blob.sum_vv);
  const Eigen::Matrix2d covariance_px2 = squares + kPixelVariance * Eigen::Matrix2d::Identity() -
                                         ellipse.centre_px * ellipse.centre_px.transpose();
  const Eigen::Matrix2d axes = mirrorAxes(ellipse.centre_px, mirror_centre_px);
  ellipse.moments_px2 = axes.transpose() * covariance_px2 * axes;
  ellipse.fill = n / (4.0 * kPi * std::sqrt(covariance_px2.determinant()));
  // A few pixels cannot look round: the tolerance is this over the number of pixels in a disc as
  // wide as the spot is narrow.
  constexpr double kSmallSpotFill = 0.5;
  const double middle = 0.5 * covariance_px2.trace();
  const double smallest = middle - std::hypot(covariance_px2(0, 0) - middle, covariance_px2(0, 1));
  ellipse.fill_tolerance = kSmallSpotFill / (4.0 * kPi * smallest);
  ellipse.pixels =
      static_cast<int>(std::min<std::int64_t>(blob.pixels, std::numeric_limits<int>::max()));
  ellipse.cut = blob.cut;
  return ellipse;
}

}  // namespace bearing_calibration::core
