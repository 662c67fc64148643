#pragma once

#include <string>
#include <vector>

#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// The simulated robot of config/simulation.yaml in a scene that files describe.
/// @param simulation_file  all parameters; empty: the package's own
/// @param scene_files  what differs, in order
/// @param seed  in place of world/seed; negative: as in the files
/// @throws std::runtime_error for a file or parameter that is wrong, and for trajectory/kind
/// cmd_vel
SimulationNodeConfig readSimulatedScene(const std::string& simulation_file,
                                        const std::vector<std::string>& scene_files, int seed);

}  // namespace bearing_calibration_ros
