#include "bearing_calibration/track/light_start.h"

#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

CartesianEstimate placeLight(const MountEstimate& base_from_sensor, const LightDistance& distance,
                             double azimuth_rad, double azimuth_variance_rad2) {
  const Eigen::Vector2d sensor = base_from_sensor.mean.head<2>();
  const double yaw = base_from_sensor.mean.z();
  const Eigen::Vector2d direction = rotation2(yaw + azimuth_rad) * Eigen::Vector2d::UnitX();
  const Eigen::Vector2d J_light_angle = distance.mean_m * perpendicular(direction);

  Eigen::Matrix<double, 5, 3> J_state_mount = Eigen::Matrix<double, 5, 3>::Zero();
  J_state_mount.topLeftCorner<2, 2>().setIdentity();
  J_state_mount.topRightCorner<5, 1>().head<2>() = J_light_angle;
  J_state_mount.bottomRows<3>().setIdentity();

  CartesianEstimate estimate;
  estimate.mean << sensor + distance.mean_m * direction, sensor, yaw;
  estimate.covariance = J_state_mount * base_from_sensor.covariance * J_state_mount.transpose();
  estimate.covariance.topLeftCorner<2, 2>() +=
      distance.stddev_m * distance.stddev_m * direction * direction.transpose() +
      azimuth_variance_rad2 * J_light_angle * J_light_angle.transpose();
  return estimate;
}

StateEstimate widenLight(StateEstimate estimate, double stddev_m, double stddev_rad) {
  const Eigen::Vector2d across = perpendicular(estimate.mean.tail<2>());
  estimate.covariance.bottomRightCorner<2, 2>() +=
      stddev_m * stddev_m * Eigen::Matrix2d::Identity() +
      stddev_rad * stddev_rad * across * across.transpose();
  return estimate;
}

}  // namespace bearing_calibration::core
