#pragma once

#include <vector>

#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core::testing {

/// The most probable mount, light and noise of every motion, by dense Gauss-Newton with numerical
/// derivatives: slow, and independent of the smoother.
/// @param start  Cartesian state at the first observation, near the optimum
/// @returns at the last observation
CartesianEstimate maximisePosterior(const std::vector<Observation>& observations,
                                    const Vector5& start);

}  // namespace bearing_calibration::core::testing
