#pragma once

#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {

/// The azimuth [rad] at which a sensor without errors sees the light, with its Jacobian by the
/// Cartesian state (model.md, eq. 6). Not defined at the sensor itself.
struct AzimuthModel {
  double azimuth_rad;
  Eigen::Matrix<double, 1, 5> J_azimuth_state;
};
AzimuthModel azimuthFromCartesian(const Vector5& state);

/// An angle [rad] at which the sensor sees a light, errors and all, with its Jacobian by the state
/// at the stamp (model.md, eqs. 6, 16, 19, 20).
struct ExpectedAngle {
  double angle_rad;
  StateRow J_angle_state;
};
/// @param nearby  the wheels' travel around the stamp
ExpectedAngle expectAzimuth(const StateLayout& layout, const StateVector& state, int light,
                            const OdometryWindow& nearby);
/// Only with the sensor's tilt in the state.
ExpectedAngle expectElevation(const StateLayout& layout, const StateVector& state, int light,
                              const OdometryWindow& nearby);

/// A measurement of one number against its prediction.
struct Innovation {
  double residual;  ///< measured minus predicted, wrapped where it is an angle
  double variance;  ///< S = H P H^T + R

  double nis() const { return residual * residual / variance; }
};

/// The EKF's update by one number, not yet applied (model.md, eq. 8).
struct ScalarUpdate {
  StateVector H;  ///< Jacobian of the measurement by the state, as a column
  StateVector gain;
  double variance;  ///< R of the measurement, > 0
  Innovation innovation;
};
/// @param residual  measured minus predicted
ScalarUpdate prepareUpdate(const StateRow& H, double residual, double variance,
                           const StateEstimate& estimate);
/// In the Joseph form, which keeps the covariance symmetric and positive whatever the gain's
/// rounding.
void apply(const ScalarUpdate& update, StateEstimate* estimate);

}  // namespace bearing_calibration::core
