#pragma once

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core {

/// The next state with its Jacobians by the state and by the increment's (x, y, yaw).
struct Propagation {
  Vector5 state;
  Matrix5 J_state_state;
  Eigen::Matrix<double, 5, 3> J_state_motion;
};

/// The azimuth [rad] at which the sensor sees the light, with its Jacobian by the state.
struct AzimuthModel {
  double azimuth_rad;
  Eigen::Matrix<double, 1, 5> J_azimuth_state;
};

/// Motion of the Cartesian state [light x y, sensor x y, sensor yaw] (doc/model.md, eq. 5).
Propagation propagateCartesian(const Vector5& state, const OdometryIncrement& motion);
/// Bearing from the Cartesian state (doc/model.md, eq. 6). Not defined at the sensor itself.
AzimuthModel azimuthFromCartesian(const Vector5& state);

/// Motion of the paper's state [D, theta, phi, rho, psi] (doc/model.md, eq. 9; the paper's eq. 12
/// for an exact arc). Not defined where the motion ends at the light.
Propagation propagatePaper(const Vector5& state, const OdometryIncrement& motion);
/// Bearing from the paper's state (doc/model.md, eq. 10; the paper's eqs. 8 and 15).
AzimuthModel azimuthFromPaper(const Vector5& state);

}  // namespace bearing_calibration::core
