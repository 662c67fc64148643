#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/search_region.h"

namespace bearing_calibration::core {

/// What the searched part of an image looks like without its lights.
struct BackgroundLevel {
  double median = 0.0;
  double spread = 0.0;  ///< robust sigma: median minus the 15.9 % quantile, which no lamp can move
};

/// Measured on a fixed grid of the strips' pixels; zeros without any.
/// @param image CV_8UC1 or CV_16UC1. @param max_level the largest that is told from full
BackgroundLevel backgroundOf(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                             double max_level);

/// Levels above which a pixel may belong to a light, in the order in which they are tried: first
/// the contrast that the configuration asks for; then higher ones, for a light in front of
/// something bright, up to what is full; last a lower one, for a dim light in front of something
/// uneven. All below saturation.
using Thresholds = std::array<int, 10>;
Thresholds thresholdsOver(const BackgroundLevel& background, const ThresholdConfig& config,
                          const ImageSensor& sensor);

/// Connected bright pixels (8 neighbours) by their integer moments.
struct Blob {
  std::int64_t pixels = 0;
  std::int64_t sum_u = 0;
  std::int64_t sum_v = 0;
  std::int64_t sum_uu = 0;
  std::int64_t sum_uv = 0;
  std::int64_t sum_vv = 0;
  bool cut = false;  ///< reaches an end of a strip of the mask, its first row or its last
};

/// Finds the connected pixels above a threshold: runs of the mask's strips, joined by union-find,
/// each adding closed sums to its blob. Buffers are kept from image to image.
class BlobSegmenter {
 public:
  /// @param image CV_8UC1 or CV_16UC1. @param strips in reading order.
  /// @param least_pixels less is a speck of noise
  /// @return the blobs, valid until the next call; none unless complete()
  const std::vector<Blob>& segment(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                                   int threshold, int least_pixels = 1);

  /// False when the last image had more bright runs than a scene with a light can have.
  bool complete() const { return complete_; }

 private:
  /// Bright pixels [begin, end) of a row.
  struct Run {
    int row;
    int begin;
    int end;
    bool cut;
    std::size_t parent;  ///< a run that this one is joined with; itself, of one that stands for all
    std::size_t blob;    ///< of one that stands for all
  };

  template <typename Level>
  bool findRuns(const cv::Mat& image, const std::vector<PixelStrip>& strips, int threshold);
  std::size_t rootOf(std::size_t run);
  bool join();
  void addUp(int least_pixels);

  std::vector<int> edges_;  ///< of a row's runs
  std::vector<Run> runs_;
  std::vector<Blob> blobs_;
  bool complete_ = true;
};

/// The blob's pixels as small squares (a lone pixel has a variance of 1/12): centre, second
/// moments, fill and how many they are.
LightEllipse ellipseOf(const Blob& blob, const Eigen::Vector2d& mirror_centre_px);

}  // namespace bearing_calibration::core
