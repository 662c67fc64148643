#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

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

/// From the sensor to the light [m].
double rangeOf(const Vector5& state);

/// The state or its twin turned by half a turn: the one that has the light in front of most
/// bearings.
Vector5 withLightInFront(const std::vector<PosedObservation>& observations,
                         const Vector5& state_at_first);

/// Mount and light fitted to bearings along a path that is taken as known.
struct FixedPathFit {
  Vector5 state_at_first = Vector5::Zero();
  double cost = 0.0;         ///< Huber's, in units of a variance
  double capped_cost = 0.0;  ///< the same, observations beyond 3 standard deviations as at 3
};

/// How a record is weighed when its path is taken as known: the odometry's error grows with the way
/// from `reference`, and is added to the bearings' own.
struct FixedPathWeight {
  std::size_t reference = 0;  ///< index of the observation where the path is exact
  double huber_sigmas = 2.0;
};

/// Measured minus expected azimuth [rad].
double residualAt(const PosedObservation& observation, const Vector5& state_at_first);

/// Standard deviation [rad] of a bearing at `range_m`, the odometry's error since the reference
/// with it.
double bearingStddev(const PosedObservation& observation, const PosedObservation& reference,
                     double range_m);

/// Costs of a state as it is.
FixedPathFit judgeOnFixedPath(const std::vector<PosedObservation>& observations,
                              const Vector5& state_at_first, const FixedPathWeight& weight);

/// Levenberg-Marquardt on the wrapped angles from `start` (start.md, eq. 4).
FixedPathFit fitOnFixedPath(const std::vector<PosedObservation>& observations, const Vector5& start,
                            const FixedPathWeight& weight);

}  // namespace bearing_calibration::core
