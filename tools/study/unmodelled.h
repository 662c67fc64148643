#pragma once

#include <string>
#include <vector>

#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// Names of Unmodelled, in its order.
const std::vector<std::string>& unmodelledNames();
/// @throws std::invalid_argument with all names.
Unmodelled unmodelledFrom(const std::string& name);

/// Makes a robot what no model of the estimators knows, as far as its settings can.
void makeUnmodelled(Unmodelled what, SimulatedCase& simulated);
/// The rest of it, on what the robot has recorded.
void distort(const SimulatedCase& simulated, SimulatedRecord* record);

}  // namespace bearing_calibration::core
