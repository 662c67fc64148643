#pragma once

#include <string>
#include <vector>

#include "tools/study/monte_carlo_trials.h"

namespace bearing_calibration::core {

/// One line for each quantity of mount and robot that was estimated, at the runs' end, over those
/// that claim: bias and scatter in units of the standard deviations that they stated; and the
/// mount's errors by themselves. Empty when no error of the robot was looked for.
std::string formatRobotErrors(const std::vector<Trial>& trials);

}  // namespace bearing_calibration::core
