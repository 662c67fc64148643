#pragma once

#include <array>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/vision/bright_spots.h"
#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/search_region.h"
#include "bearing_calibration/vision/spot_meter.h"

namespace bearing_calibration::core {

/// What one image showed.
struct DetectionResult {
  std::vector<Detection> lights;  ///< accepted
  /// At the first threshold: the first max_candidates of them, for people to see.
  std::vector<Detection> rejected;
  std::array<int, kRejections> rejections{};  ///< how many of each, by Rejection; specks left out
  BackgroundLevel background;
  int threshold_levels = 0;
  double part_searched = 1.0;  ///< of the mask
  bool in_region = false;      ///< likely in the predicted region: the rest was not looked at
  bool opened = false;         ///< found where bright areas wider than a light were taken away
  bool too_cluttered = false;  ///< more bright runs than a scene with a light can have: gave up
};

/// Finds the image of a light, in a conic mirror or without one. An image's way to its bearings:
/// where to look, from which level on, which pixels are connected, their ellipse of light, the
/// probability that it is a light, its centre's variance (detection.md).
class LightDetector {
 public:
  /// What is as likely as this is not looked for elsewhere.
  static constexpr double kLikely = 0.5;

  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit LightDetector(const DetectorConfig& config);

  /// @param image CV_8UC1 or CV_16UC1 of the configured size.
  /// @param region looked at first, its place before its sector; the whole mask follows when
  ///   nothing likely is there.
  /// @return valid until the next call. Without software defocus nothing is allocated once the
  ///   buffers have grown to what the scene needs.
  /// @throws std::invalid_argument for an image of another type or size, or of a depth that cannot
  ///   reach the configured saturation, and of a camera without its numbers.
  const DetectionResult& detect(const cv::Mat& image,
                                const std::optional<SearchRegion>& region = std::nullopt);

  const DetectorConfig& config() const { return config_; }

 private:
  void search(const SearchedImage& image, const std::vector<PixelStrip>& strips);
  void scan(const SearchedImage& image, const std::vector<PixelStrip>& strips, bool opened,
            DetectionResult* result);
  void examine(const SearchedImage& image, const std::vector<Blob>& blobs, const Search& search,
               DetectionResult* result);
  Rejection measure(const SearchedImage& image, const Search& search,
                    const std::vector<Detection>& refused, Detection* spot) const;

  DetectorConfig config_;
  AnnulusMask mask_;
  double mask_px_;                                ///< pixels of the whole mask
  std::unique_ptr<const ExpectedSpot> expected_;  ///< null: nothing is, without the mirror's gates
  BlobSegmenter segmenter_;
  std::vector<PixelStrip> region_;
  cv::Mat defocused_;
  cv::Mat wider_than_a_light_;  ///< element of the opening
  cv::Mat opened_;              ///< the image less its opening
  bool opened_is_of_image_ = false;
  DetectionResult result_;
  DetectionResult opened_result_;
  std::vector<Detection> lights_;  ///< over one threshold
};

}  // namespace bearing_calibration::core
