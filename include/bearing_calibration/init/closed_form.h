#pragma once

#include <Eigen/Core>
#include <optional>

#include "bearing_calibration/record/observation_path.h"

namespace bearing_calibration::core {

/// Light, sensor and yaw from bearings in closed form (start.md, eqs. 1 to 3): turned into the
/// sensor's direction, light and sensor obey one linear homogeneous equation for each bearing, and
/// the yaw is an eigenvector of a 2x2 matrix: the global optimum of the algebraic cost.
///
/// States are Cartesian, with the light in the base frame of the record's first observation.
class ClosedForm {
 public:
  void add(const PosedObservation& observation, double weight);

  /// The yaw is found up to half a turn: both answers have the light on the line of every bearing,
  /// see withLightInFront(). None when the motion leaves the rest undetermined.
  std::optional<Vector5> solve() const;

  /// Light and sensor for a given yaw.
  std::optional<Vector5> solveFor(double sensor_yaw_rad) const;

 private:
  std::optional<Vector5> stateFor(const Eigen::Vector2d& yaw_direction) const;

  Eigen::Matrix<double, 6, 6> moment_ = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Cartesian state at an observation from that at the first one.
Vector5 stateAt(const PosedObservation& observation, const Vector5& state_at_first);

/// The state or its twin turned by half a turn: the one that has the light in front of most
/// bearings.
Vector5 withLightInFront(const std::vector<PosedObservation>& observations,
                         const Vector5& state_at_first);

}  // namespace bearing_calibration::core
