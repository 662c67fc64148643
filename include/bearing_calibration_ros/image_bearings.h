#pragma once

#include <sensor_msgs/Image.h>

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/vision/blink_identifier.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration/vision/light_tracks.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Image messages in, bearings out: what the detection nodelet and the offline tools share.
class ImageBearings {
 public:
  explicit ImageBearings(const DetectionNodeConfig& config)
      : config_(config), detector_(config.detector), tracks_(config.search) {
    if (config.blink.use) blink_.emplace(config.blink);
    if (config.detector.mirror_kind == core::MirrorKind::kCone) learner_.emplace(config.detector);
  }

  /// Looks with another detector from the next image on; what is known of blinking, and what is
  /// learnt of the optics, stays.
  void setDetector(const core::DetectorConfig& detector) {
    config_.detector = detector;
    detector_ = core::LightDetector(learner_ ? learner_->applied(detector) : detector);
    result_ = nullptr;
  }

  /// What the pixels of the next image see: without a mirror each image needs it.
  void setCamera(const core::Camera& camera) {
    if (config_.detector.camera == camera) return;
    core::DetectorConfig detector = config_.detector;
    detector.camera = camera;
    setDetector(detector);
    view_ = core::viewOf(camera, detector.sensor.width_px, detector.mask.last_row + 1);
  }

  /// Moment of the image's middle row, for which a prediction is of use.
  core::Stamp middleOf(const sensor_msgs::Image& image) const {
    return core::midExposure(config_.shutter, stampFromRos(image.header.stamp),
                             0.5 * config_.detector.sensor.height_px);
  }

  /// @param image  that refusalOf() has nothing against
  /// @param prediction  of the bearing at about that moment
  core::BearingSet detect(const sensor_msgs::ImageConstPtr& image,
                          const std::optional<core::BearingPrediction>& prediction) {
    if (learner_ && learner_->hasNews()) setDetector(config_.detector);
    const bool look_everywhere =
        images_++ % static_cast<std::uint64_t>(config_.full_scan_every) == 0;
    std::optional<core::SearchRegion> region;
    // What blinks is not seen in every image, and another colour may be where the light is
    // expected: the others must be looked at, too. Sectors are those of a mirror.
    if (prediction && !look_everywhere && !blink_ && !config_.colour.use && hasMirror()) {
      region = core::searchRegion(config_.search, *prediction, seen_, middleOf(*image));
    }
    grey_ = &converter_.convert(image);
    result_ = &detector_.detect(*grey_, region);
    core::BearingSet bearings = core::bearingsFromLights(result_->lights, config_.shutter,
                                                         stampFromRos(image->header.stamp),
                                                         config_.detector.sensor.height_px);
    bearings.view = view_;
    if (hasMirror()) bearings.geometry = config_.detector.alignment.geometry;
    seen_ = prediction ? core::seenRadius(bearings, *prediction) : std::nullopt;
    if (blink_) {
      blink_->identify(result_->lights, &bearings);
    } else {
      tracks_.follow(result_->part_searched, prediction, &bearings);
    }
    if (config_.colour.use) {
      const double full_levels = config_.detector.sensor.saturation_level;
      const auto colours = core::coloursOf(converter_.convertToColour(image, full_levels),
                                           result_->lights, config_.detector);
      core::identifyByColour(config_.colour, colours, &bearings);
    }
    if (learner_ && prediction) learner_->see(result_->lights, bearings, *prediction);
    return bearings;
  }

  /// What the last image showed, and that image in grey.
  const core::DetectionResult& result() const { return *result_; }
  const cv::Mat& grey() const { return *grey_; }
  /// What is learnt of the optics; none without a conic mirror.
  const std::optional<core::OpticsLearner>& learner() const { return learner_; }

 private:
  bool hasMirror() const { return config_.detector.mirror_kind != core::MirrorKind::kNone; }

  DetectionNodeConfig config_;
  core::LightDetector detector_;
  core::LightTracks tracks_;
  std::optional<core::OpticsLearner> learner_;
  std::optional<core::BlinkIdentifier> blink_;  ///< none unless blink/use is set; instead of tracks
  GreyConverter converter_;
  const core::DetectionResult* result_ = nullptr;
  const cv::Mat* grey_ = nullptr;
  std::optional<core::SeenRadius> seen_;  ///< by the last light that was expected
  core::FieldOfView view_;                ///< of a camera without a mirror
  std::uint64_t images_ = 0;
};

}  // namespace bearing_calibration_ros
