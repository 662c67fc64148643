#include "bearing_calibration_ros/image_bearings.h"

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {

ImageBearings::ImageBearings(const DetectionNodeConfig& config)
    : config_(config), detector_(config.detector) {
  if (config.blink.use) blink_.emplace(config.blink);
}

void ImageBearings::setDetector(const core::DetectorConfig& detector) {
  config_.detector = detector;
  detector_ = core::LightDetector(detector);
  result_ = nullptr;
}

core::Stamp ImageBearings::middleOf(const sensor_msgs::Image& image) const {
  return core::midExposure(config_.shutter, stampFromRos(image.header.stamp),
                           0.5 * config_.detector.sensor.height_px);
}

core::BearingSet ImageBearings::detect(const sensor_msgs::ImageConstPtr& image,
                                       const std::optional<core::BearingPrediction>& prediction) {
  const bool look_everywhere = images_++ % static_cast<std::uint64_t>(config_.full_scan_every) == 0;
  std::optional<core::SearchRegion> region;
  // What blinks is not seen in every image, and another colour may be where the light is expected:
  // the others must be looked at, too.
  if (prediction && !look_everywhere && !blink_ && !config_.colour.use) {
    region = core::searchRegion(config_.search, *prediction, seen_, middleOf(*image));
  }
  grey_ = &converter_.convert(image);
  result_ = &detector_.detect(*grey_, region);
  core::BearingSet bearings =
      core::bearingsFromLights(result_->lights, config_.shutter, stampFromRos(image->header.stamp),
                               config_.detector.sensor.height_px);
  bearings.geometry = config_.detector.alignment.geometry;
  seen_ = prediction ? core::seenRadius(bearings, *prediction) : std::nullopt;
  if (blink_) blink_->identify(core::brightnessOf(result_->lights), &bearings);
  if (config_.colour.use) {
    const auto colours =
        core::coloursOf(converter_.convertToColour(image, config_.detector.sensor.saturation_level),
                        result_->lights, config_.detector);
    core::identifyByColour(config_.colour, colours, &bearings);
  }
  return bearings;
}

}  // namespace bearing_calibration_ros
