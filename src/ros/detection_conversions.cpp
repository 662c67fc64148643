#include "bearing_calibration_ros/detection_conversions.h"

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

msg::LightBearing messageFromBearing(const core::Bearing& bearing) {
  msg::LightBearing message;
  message.azimuth = bearing.azimuth_rad;
  message.azimuth_variance = bearing.azimuth_variance_rad2;
  message.image_radius = bearing.image_radius_px;
  message.image_radius_variance = bearing.image_radius_variance_px2;
  message.elevation = bearing.elevation_rad;
  message.elevation_variance = bearing.elevation_variance_rad2;
  message.light_id = bearing.light_id;
  message.probability = static_cast<float>(bearing.probability);
  return message;
}

}  // namespace

msg::LightBearings messageFromBearings(const core::BearingSet& set,
                                       const std::string& sensor_frame) {
  msg::LightBearings message;
  message.header.stamp = rosFromStamp(set.stamp);
  message.header.frame_id = sensor_frame;
  message.harmonic_stddev = set.geometry.harmonic_stddev_rad;
  message.near_per_far = set.geometry.near_per_far_m;
  message.nearness_stddev = set.geometry.nearness_stddev_rad_m;
  message.candidates.reserve(set.candidates.size());
  for (const core::Bearing& bearing : set.candidates) {
    message.candidates.push_back(messageFromBearing(bearing));
  }
  return message;
}

core::BearingPrediction predictionFromMessage(const msg::PredictedBearing& message) {
  return {stampFromRos(message.header.stamp), message.azimuth, message.azimuth_variance,
          message.light_id};
}

}  // namespace bearing_calibration_ros
