#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

/// Covariance that the noise of a motion gives a light that is seen from the motion's end.
Eigen::Matrix2d lightNoise(const OdometryIncrement& motion, const Eigen::Vector2d& light_at_end);

/// A state near enough to the truth, at one of a record's observations.
struct RecordStart {
  Vector5 state = Vector5::Zero();  ///< Cartesian
  std::size_t observation = 0;      ///< its index in the record
  ErrorVector errors = ErrorVector::Zero();
};

/// A record seen from a known mount.
struct LightTrack {
  std::vector<Vector5> states;     ///< Cartesian, at each observation
  std::vector<bool> is_plausible;  ///< of each observation: false where something else was seen
};

/// Follows the light from `start` to both ends of the record by odometry and bearings, so that
/// neither the odometry's drift nor a slip nor outliers nor another light lead astray: what a
/// smoother pass is linearised about first.
LightTrack trackLight(const std::vector<Observation>& observations, const RecordStart& start);

}  // namespace bearing_calibration::core
