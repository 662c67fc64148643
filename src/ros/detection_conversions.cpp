#include "bearing_calibration_ros/detection_conversions.h"

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

bearing_calibration::LightBearing messageFromBearing(const bearing_calibration::Bearing& bearing) {
  bearing_calibration::LightBearing message;
  message.azimuth = bearing.azimuth_rad;
  message.azimuth_variance = bearing.azimuth_variance_rad2;
  message.image_radius = bearing.image_radius_px;
  message.image_radius_variance = bearing.image_radius_variance_px2;
  message.elevation = bearing.elevation_rad;
  message.elevation_variance = bearing.elevation_variance_rad2;
  message.light_id = bearing.light_id;
  message.quality = static_cast<float>(bearing.quality);
  return message;
}

}  // namespace

bearing_calibration::LightBearings messageFromBearings(const bearing_calibration::BearingSet& set,
                                                       const std::string& sensor_frame) {
  bearing_calibration::LightBearings message;
  message.header.stamp = rosFromStamp(set.stamp);
  message.header.frame_id = sensor_frame;
  message.candidates.reserve(set.candidates.size());
  for (const bearing_calibration::Bearing& bearing : set.candidates) {
    message.candidates.push_back(messageFromBearing(bearing));
  }
  return message;
}

bearing_calibration::BearingPrediction predictionFromMessage(
    const bearing_calibration::PredictedBearing& message) {
  return {stampFromRos(message.header.stamp), message.azimuth, message.azimuth_variance,
          message.light_id};
}

}  // namespace bearing_calibration_ros
