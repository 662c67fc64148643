#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {

/// What is still true when a robot starts anew: the mount, and those errors that are the robot's
/// own for good (its wheels, its mirror, how its sensor is tilted), as they hang together. An
/// estimate without lights and with all errors, which has no row and column of an error that does
/// not last, or was not looked for.
StateEstimate lastingPart(const StateEstimate& estimate);
StateEstimate lastingPart(const MountEstimate& mount);

/// "x [m]" and so on, for each number of a lasting part.
std::vector<std::string> lastingNames();

/// Adds an earlier calibration to an estimate that rests on other measurements. What was known of
/// the errors before either of them is a part of both, and is counted once (model.md, eq. 25).
/// @param earlier  a lasting part
/// @param priors  of both
void addEarlier(const StateEstimate& earlier, const ErrorPriors& priors, StateEstimate* estimate);

}  // namespace bearing_calibration::core
