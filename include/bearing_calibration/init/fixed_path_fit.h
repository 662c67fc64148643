#pragma once

#include <cstddef>

#include "bearing_calibration/record/observation_path.h"

namespace bearing_calibration::core {

/// Mount and light fitted to bearings along a path that is taken as known.
struct FixedPathFit {
  Vector5 state_at_first = Vector5::Zero();
  double cost = 0.0;  ///< Huber's, in units of a variance
  double capped_cost =
      0.0;  ///< the same with every observation beyond 3 standard deviations as one at 3
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
