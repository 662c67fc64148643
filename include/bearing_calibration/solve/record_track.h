#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

/// Mount, errors and lights near enough to the truth, at one of a record's observations.
struct RecordStart {
  RecordStart() = default;
  RecordStart(const Vector5& state, std::size_t at,
              const ErrorVector& robot_errors = ErrorVector::Zero())
      : mount(state.tail<kMountSize>()),
        errors(robot_errors),
        lights_in_base(state.head<2>()),
        observation(at) {}
  RecordStart(const StateEstimate& estimate, std::size_t at);

  Eigen::Vector3d mount = Eigen::Vector3d::Zero();
  ErrorVector errors = ErrorVector::Zero();
  LightPositions lights_in_base;
  std::size_t observation = 0;  ///< its index in the record
};

/// A path near enough to the truth, for a fit to begin with.
struct RecordTrack {
  RecordPath path;
  std::vector<bool> is_plausible;  ///< of each observation: false where something else was seen
};

/// Follows each light from `start` to both ends of the record by odometry and bearings, so that
/// neither the odometry's drift nor a slip nor outliers nor another light lead astray.
RecordTrack trackLights(const std::vector<Observation>& observations, const RecordStart& start);

}  // namespace bearing_calibration::core
