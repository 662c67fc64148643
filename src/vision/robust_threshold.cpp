#include "bearing_calibration/vision/robust_threshold.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace bearing_calibration::core {
namespace {

// Some three thousand samples of a 640x480 image, a hundred and fifty of a sector of +-10 degrees,
// a hundred of the patch around a light: enough for a quantile to a tenth of the spread. Steps that
// share no factor with the blocks of 8 pixels of JPEG.
struct Grid {
  int row_step;
  int column_step;
};
Grid gridFor(int rows) {
  constexpr int kFewRows = 40;
  constexpr int kSomeRows = 100;
  if (rows < kFewRows) return {3, 5};
  return rows < kSomeRows ? Grid{7, 7} : Grid{7, 9};
}
constexpr int kMaxBins = 1024;
constexpr double kOneSigmaBelow = 0.1587;  // of a normal distribution

/// So that a level's bin is found by a shift: a division by what is not known beforehand takes
/// longer than everything else that a sample needs.
int shiftFor(double max_level) {
  int shift = 0;
  while (static_cast<int>(max_level) >> shift >= kMaxBins) ++shift;
  return shift;
}

}  // namespace

BackgroundSampler::BackgroundSampler(double max_level)
    : shift_(shiftFor(max_level)),
      histogram_((static_cast<std::size_t>(max_level) >> shift_) + 1, 0) {}

template <typename Level>
int BackgroundSampler::fillHistogram(const cv::Mat& image, const std::vector<PixelStrip>& strips) {
  if (strips.empty()) return 0;
  const Grid grid = gridFor(strips.back().row - strips.front().row + 1);
  int samples = 0;
  const int last_bin = static_cast<int>(histogram_.size()) - 1;
  for (const PixelStrip& strip : strips) {
    if (strip.row % grid.row_step != 0) continue;
    const Level* row = image.ptr<Level>(strip.row);
    for (int u = strip.begin; u < strip.end; u += grid.column_step) {
      ++histogram_[static_cast<std::size_t>(std::min(row[u] >> shift_, last_bin))];
      ++samples;
    }
  }
  return samples;
}

double BackgroundSampler::quantile(double wanted) const {
  const double levels_per_bin = static_cast<double>(1U << shift_);
  int seen = 0;
  for (std::size_t bin = 0; bin < histogram_.size(); ++bin) {
    const int here = histogram_[bin];
    if (here > 0 && seen + here >= wanted) {
      // Levels are integers: within a bin the samples are taken as spread evenly about its middle.
      const double within = (wanted - seen) / here - 0.5;
      return levels_per_bin * (static_cast<double>(bin) + 0.5 + within) - 0.5;
    }
    seen += here;
  }
  return 0.0;
}

BackgroundLevel BackgroundSampler::measure(const cv::Mat& image,
                                           const std::vector<PixelStrip>& strips) {
  std::fill(histogram_.begin(), histogram_.end(), 0);
  const int samples = image.depth() == CV_8U ? fillHistogram<std::uint8_t>(image, strips)
                                             : fillHistogram<std::uint16_t>(image, strips);
  if (samples == 0) return {};
  const double median = quantile(0.5 * samples);
  return {median, median - quantile(kOneSigmaBelow * samples)};
}

ThresholdLadder::ThresholdLadder(const BackgroundLevel& background, const ThresholdConfig& config,
                                 const ImageSensor& sensor)
    : highest_(sensor.saturation_level - 1.0) {  // what is full is always seen
  // The last one lies where a textured background still shows no blobs of a light's size.
  constexpr double kLowerPart = 0.5;
  const auto above = [&](double spreads) {
    const double contrast = std::max(config.min_contrast_levels, spreads * background.spread);
    return std::min(background.median + contrast, highest_);
  };
  first_ = above(config.spreads);
  last_ = above(kLowerPart * config.spreads);
}

int ThresholdLadder::at(int step) const {
  constexpr int kRises = kSteps - 2;
  if (step == 0) return static_cast<int>(first_);
  if (step > kRises) return static_cast<int>(last_);
  return static_cast<int>(first_ + (highest_ - first_) * step / kRises);
}

}  // namespace bearing_calibration::core
