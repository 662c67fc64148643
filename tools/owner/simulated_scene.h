#pragma once

#include <boost/program_options.hpp>
#include <string>
#include <vector>

#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// Which scene a program is to simulate, by its command line.
struct SceneArguments {
  std::string simulation_file;           ///< all parameters; empty: the package's own
  std::vector<std::string> scene_files;  ///< what differs, in order
  int seed = -1;                         ///< in place of world/seed; negative: as in the files

  /// --scene, --simulation and --seed. @throws boost::program_options::error from parsing them
  void addTo(boost::program_options::options_description* description);
};

/// The simulated robot of config/simulation.yaml in a scene that files describe.
/// @throws std::runtime_error for a file or parameter that is wrong, and for trajectory/kind
/// cmd_vel
SimulationNodeConfig readSimulatedScene(const SceneArguments& arguments);

}  // namespace bearing_calibration_ros
