#pragma once

#include <functional>

#include "bearing_calibration/simulation/robot_simulator.h"

namespace bearing_calibration::core {

/// A camera under its mirror, rendered, and the detector that finds the light in its images, both
/// as they are shipped, with an exposure control. For DrivenCase::look.
std::function<BearingSet(const RobotSimulator&)> imageLook(std::uint64_t seed);

}  // namespace bearing_calibration::core
