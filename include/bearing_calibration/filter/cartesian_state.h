#pragma once

#include <Eigen/Core>
#include <optional>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

/// Positions of the quantities in the Cartesian state vector, everything in the base frame of now:
/// [light x, light y, sensor x, sensor y, sensor yaw]. No singularity but at the sensor itself
/// (doc/model.md, section "Cartesian parametrisation").
struct CartesianIndex {
  enum : int { kLightX = 0, kLightY = 1, kSensorX = 2, kSensorY = 3, kSensorYaw = 4 };
};

/// Mean [m, m, m, m, rad] and covariance of the Cartesian state.
struct CartesianEstimate {
  Vector5 mean = Vector5::Zero();
  Matrix5 covariance = Matrix5::Zero();

  Eigen::Vector2d lightInBase() const { return mean.head<2>(); }
  Eigen::Vector2d sensorInBase() const { return mean.segment<2>(CartesianIndex::kSensorX); }
  double sensorYaw() const { return mean(CartesianIndex::kSensorYaw); }
};

/// One bearing of the light with the base's motion since the bearing before it: what the
/// initialiser and the batch estimator keep of a record.
struct Observation {
  Stamp stamp;
  OdometryIncrement motion;  ///< from the previous observation's moment to this one's
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;
  OdometryWindow nearby;  ///< around the stamp; no motion where nobody asks for the time offset
  std::optional<Elevation> elevation = std::nullopt;  ///< where the sensor has one
  int light = 0;                                      ///< which one of a record's lights
};

}  // namespace bearing_calibration::core
