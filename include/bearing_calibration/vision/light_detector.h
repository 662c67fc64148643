#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/annulus_mask.h"
#include "bearing_calibration/vision/blob_segmenter.h"
#include "bearing_calibration/vision/detection_gates.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"
#include "bearing_calibration/vision/light_ellipse.h"
#include "bearing_calibration/vision/robust_threshold.h"
#include "bearing_calibration/vision/search_region.h"
#include "bearing_calibration/vision/spot_meter.h"

namespace bearing_calibration::core {

/// A bright spot of an image: the light, or what was mistaken for it and why it was not.
struct Detection {
  /// Where a gate before the measurement failed: centre, size, fill and pixels as thresholded.
  LightEllipse ellipse;
  Bearing bearing;  ///< only of an accepted spot
  Rejection rejection = Rejection::kNone;

  bool accepted() const { return rejection == Rejection::kNone; }
};

/// The one of the highest probability; null without any.
const Detection* likeliestLight(const std::vector<Detection>& lights);

/// What one image showed.
struct DetectionResult {
  std::vector<Detection> lights;  ///< accepted
  /// At the first threshold: the first max_candidates of them, for people to see.
  std::vector<Detection> rejected;
  std::array<int, kRejections> rejections{};  ///< how many of each, by Rejection; specks left out
  BackgroundLevel background;
  int threshold_levels = 0;
  bool in_region = false;      ///< found in the predicted region: the rest was not looked at
  bool opened = false;         ///< found where bright areas wider than a light were taken away
  bool too_cluttered = false;  ///< more bright runs than a scene with a light can have: gave up
};

/// Finds the image of a light in a conic mirror: background, threshold, connected pixels, gates,
/// intensity centroid, gates again, variance.
class LightDetector {
 public:
  /// What is as likely as this is not looked for elsewhere.
  static constexpr double kLikely = 0.5;

  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit LightDetector(const DetectorConfig& config);

  /// @param image CV_8UC1 or CV_16UC1 of the configured size.
  /// @param region looked at first, its place before its sector; the whole mask follows when
  ///   nothing is accepted there.
  /// @return valid until the next call. Without software defocus nothing is allocated once the
  ///   buffers have grown to what the scene needs.
  /// @throws std::invalid_argument for an image of another type or size, or of a depth that cannot
  ///   reach the configured saturation.
  const DetectionResult& detect(const cv::Mat& image,
                                const std::optional<SearchRegion>& region = std::nullopt);

  const DetectorConfig& config() const { return config_; }

 private:
  void requireImage(const cv::Mat& image) const;
  void searchBesideBrightAreas(const cv::Mat& image, const cv::Mat& sharp,
                               const std::vector<PixelStrip>& strips);
  void scan(const cv::Mat& image, const cv::Mat& sharp, const std::vector<PixelStrip>& strips);
  double logPartOf(const std::vector<PixelStrip>& strips) const;
  bool likely() const { return probabilityOfBest(result_) >= kLikely; }
  static double probabilityOfBest(const DetectionResult& result);
  void examine(const cv::Mat& image, const cv::Mat& sharp, const std::vector<Blob>& blobs,
               bool with_rejected);
  void measure(const cv::Mat& image, const cv::Mat& sharp, const BlobShape& shape,
               Detection* detection);
  void listRejected(const Detection& detection);
  bool cutByMask(const PixelEllipse& window) const;
  SpotWindow windowFor(const BlobShape& shape) const;

  DetectorConfig config_;
  AnnulusMask mask_;
  ExpectedSpot expected_;
  double largest_radius_px_;
  BackgroundSampler sampler_;
  BlobSegmenter segmenter_;
  std::vector<PixelStrip> region_;
  cv::Mat defocused_;
  cv::Mat wider_than_a_light_;  ///< element of the opening
  cv::Mat opened_;
  bool opened_is_of_image_ = false;
  std::int64_t mask_px_ = 0;  ///< pixels of the whole mask
  Search search_;             ///< what was tried until now
  DetectionResult result_;
  DetectionResult other_result_;
  std::vector<Detection> best_lights_;  ///< of the thresholds until now
};

}  // namespace bearing_calibration::core
