#pragma once

#include <vector>

#include "bearing_calibration/record/observation_path.h"

namespace bearing_calibration::core::testing {

/// The independent check of the closed form and of the search: scans the sensor's yaw, solves light
/// and sensor by linear least squares at each (by QR, reweighted by range, without the closed
/// form's moment matrix), and keeps the yaw of the least sum of squared angles.
/// @returns the Cartesian state at the first observation, on the grid of yaws
Vector5 scanYaw(const std::vector<PosedObservation>& observations, int yaws);

/// Sum of the squared, wrapped angles between the bearings and a state at the first observation.
double angularCost(const std::vector<PosedObservation>& observations,
                   const Vector5& state_at_first);

}  // namespace bearing_calibration::core::testing
