#pragma once

#include <Eigen/Core>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

/// A steady light: a luminous ball.
struct Light {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  ///< in the world frame
  double height_m = 0.0;    ///< over the sensor's origin (the apex of an aligned mirror)
  double brightness = 1.0;  ///< radiant intensity; 1 is what the camera's exposure is set for
  double radius_m = 0.0;    ///< 0 is a point
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< of one that is moved

  Eigen::Vector3d place_m() const { return {position_m.x(), position_m.y(), height_m}; }
};

/// `light` with its position in the frame of a sensor that stands upright.
inline Light inSensor(const Light& light, const Pose2& world_from_sensor) {
  Light seen = light;
  seen.position_m = world_from_sensor.inverse() * light.position_m;
  return seen;
}

/// Exact azimuth [rad] of `light`, counter-clockwise from the sensor's x axis.
inline double azimuthOf(const Light& light, const Pose2& world_from_sensor) {
  const Eigen::Vector2d offset = light.position_m - world_from_sensor.position_m;
  return wrapAngle(std::atan2(offset.y(), offset.x()) - world_from_sensor.yaw_rad);
}

}  // namespace bearing_calibration::core
