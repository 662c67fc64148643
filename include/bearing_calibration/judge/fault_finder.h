#pragma once

#include <vector>

#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/judge/fault.h"

namespace bearing_calibration::core {

/// Looks for the one fault up to kLightMoved that makes a record fit: undoes each in turn and
/// starts from nothing on what is left. kNone when no single fault does, or when the record fits as
/// it is.
/// @param wheel_separation_m  nominal
/// @param known  errors of the robot that the calibration has estimated already: no fault of these
Diagnosis findFault(const std::vector<Observation>& observations, double wheel_separation_m,
                    const InitializerConfig& config, const ErrorPriors& known = {});

/// Wheels that an estimate has had to take for others than they can be by what was known: in their
/// ratio, or against their separation. kNone where there are none.
Diagnosis unlikelyWheels(const ErrorEstimate& estimate, const ErrorPriors& priors);

}  // namespace bearing_calibration::core
