#include "tools/simulated_scene.h"

#include <ros/time.h>

#include <stdexcept>

#include "bearing_calibration_ros/parameter_files.h"

namespace bearing_calibration_ros {

SimulationNodeConfig readSimulatedScene(const std::string& simulation_file,
                                        const std::vector<std::string>& scene_files, int seed) {
  ros::Time::init();  // there is no node: the time is the wall's
  std::vector<std::string> files{simulation_file.empty() ? packagedConfig("simulation.yaml")
                                                         : simulation_file};
  files.insert(files.end(), scene_files.begin(), scene_files.end());
  XmlRpc::XmlRpcValue parameters = parametersFromFiles(files);
  if (seed >= 0) parameters["world"]["seed"] = seed;
  SimulationNodeConfig config = readSimulationNodeConfig(ParamReader(parameters, ""));
  if (config.driving.follows_commands) {
    throw std::runtime_error("trajectory/kind is cmd_vel: nobody gives commands here");
  }
  return config;
}

}  // namespace bearing_calibration_ros
