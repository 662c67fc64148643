#pragma once

#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {

/// A motion as a robot with these errors has made it, with its Jacobian by all of them.
CorrectedMotion<kErrorCount> correctMotion(const OdometryIncrement& measured,
                                           const ErrorVector& errors);

/// A motion of the base, linearised about its own error and those of the robot, as it moves all
/// lights: l+ = R (l - t) - J error + J_errors (errors - errors*) (model.md, eq. 5).
struct LinearMotion {
  Pose2 start_from_end;  ///< the measured one with both kinds of error put right
  Eigen::Matrix2d R_end_start;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();       ///< true minus measured (x, y, yaw)
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of that error
  ErrorVector errors_at;                                 ///< the robot's, where it is linearised
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 2 * kMostLights, 3> J_lights_error;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 2 * kMostLights, kErrorCount>
      J_lights_errors;
};

/// @param lights_at_end  where the lights are after the motion, in the base frame
/// @param error  of the motion, where it is linearised
LinearMotion lineariseMotion(const StateLayout& layout, const ErrorVector& errors,
                             const LightPositions& lights_at_end, const OdometryIncrement& measured,
                             const Eigen::Vector3d& error);
/// The same about a state before the motion, which has no error of its own.
LinearMotion lineariseMotion(const StateLayout& layout, const StateVector& before,
                             const OdometryIncrement& measured);

/// Moves an estimate (model.md, eq. 7).
void propagate(const LinearMotion& motion, StateEstimate* estimate);
/// The same by a motion that is linearised at the estimate.
void propagate(const OdometryIncrement& measured, StateEstimate* estimate);

}  // namespace bearing_calibration::core
