#pragma once

#include <vector>

#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {

/// What a record says when nobody knows where wheels slipped. A slip shows by what giving up a
/// motion takes off the cost; another place, or one slip more, may explain the record almost as
/// well, with another mount. Then the truth is with one of them, and nothing narrower than all of
/// them together may be believed.
struct SlipAverage {
  BatchEstimate best;  ///< of all suppositions, the one of least cost
  /// The best one that leaves out every slip which is not beyond doubt: what is made final.
  BatchEstimate trusting;
  StateEstimate estimate;  ///< mean and covariance over all, weighted by exp(-cost / 2)
  RivalMount rival;        ///< of `estimate`, among all suppositions
};

/// Tries rivals of a fit: each of its slips in other places, and one slip more.
/// @param batch  a fit of `observations` that has settled
SlipAverage averageOverSlips(const std::vector<Observation>& observations,
                             const BatchEstimate& batch, const BatchConfig& config);

}  // namespace bearing_calibration::core
