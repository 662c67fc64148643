#pragma once

#include <vector>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

/// What the base did over a record, as far as it decides what can be determined.
struct MotionSummary {
  double path_m = 0.0;
  double turn_rad = 0.0;  ///< sum of the absolute turns
  double extent_m = 0.0;  ///< diagonal of the box around the path
  /// Standard deviation of the path's end along one direction, by the noise of its ways alone. A
  /// motion that nobody has counted moves no path.
  double extent_noise_m = 0.0;
  /// How much of the motion is of another curvature than most of it, as a length: 0 for one circle,
  /// one line or one spin. Two different curvatures are needed (model.md, "Observability").
  double second_curvature_m = 0.0;
};

MotionSummary summariseMotion(const std::vector<Observation>& observations);

/// The combination of quantities that is known least. Yaw counts with the light's range as its
/// lever, so that all components are lengths.
struct WeakestDirection {
  Vector5 direction = Vector5::Zero();  ///< unit vector over CartesianIndex, yaw times the lever
  double stddev_m = 0.0;
  double lever_m = 0.0;  ///< distance from the sensor to the light
};

WeakestDirection weakestDirection(const CartesianEstimate& estimate);

/// Covariance at the last observation that no unbiased estimator can beat: the information of all
/// observations, linearised at the truth (Cramer-Rao bound, model.md).
/// @param light_in_base,mount  the true light in the base frame at each observation, and the true
///   mount (x [m], y [m], yaw [rad])
/// @param errors,priors  the robot's true ones, and what is known of them beforehand
StateEstimate cramerRaoBound(const std::vector<Observation>& observations,
                             const std::vector<Eigen::Vector2d>& light_in_base,
                             const Eigen::Vector3d& mount,
                             const ErrorVector& errors = ErrorVector::Zero(),
                             const ErrorPriors& priors = {});

}  // namespace bearing_calibration::core
