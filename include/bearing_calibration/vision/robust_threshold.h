#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/annulus_mask.h"
#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

/// What the masked part of an image looks like without its lights.
struct BackgroundLevel {
  double median = 0.0;
  double spread = 0.0;  ///< robust sigma: median minus the 15.9 % quantile, which no lamp can move
};

/// Measures the background on a fixed grid of the mask's pixels.
class BackgroundSampler {
 public:
  /// `max_level`: the largest level that is told from full (the rest counts as that).
  explicit BackgroundSampler(double max_level);

  /// @param image CV_8UC1 or CV_16UC1. No pixel sampled gives zeros.
  BackgroundLevel measure(const cv::Mat& image, const std::vector<PixelStrip>& strips);

 private:
  template <typename Level>
  int fillHistogram(const cv::Mat& image, const std::vector<PixelStrip>& strips);
  double quantile(double wanted) const;  ///< the level with `wanted` samples below it

  int shift_;  ///< a level is in bin level >> shift_
  std::vector<int> histogram_;
};

/// Levels above which a pixel may belong to a light, in the order in which they are tried: first
/// the contrast that the configuration asks for; then higher ones, for a light in front of
/// something bright, up to what is full; last a lower one, for a dim light in front of something
/// uneven. All below saturation.
class ThresholdLadder {
 public:
  static constexpr int kSteps = 10;

  ThresholdLadder(const BackgroundLevel& background, const ThresholdConfig& config,
                  const ImageSensor& sensor);

  int at(int step) const;  ///< 0 to kSteps - 1

 private:
  double first_;
  double highest_;
  double last_;
};

}  // namespace bearing_calibration::core
