#include "tools/simulated_scene.h"

#include <ros/package.h>
#include <ros/time.h>

#include <stdexcept>

#include "bearing_calibration_ros/parameter_files.h"

namespace bearing_calibration_ros {
namespace {

std::string packagedSimulation() {
  const std::string package = ros::package::getPath("bearing_calibration");
  if (package.empty()) {
    throw std::runtime_error("the package is not on ROS_PACKAGE_PATH: use rosrun, or --simulation");
  }
  return package + "/config/simulation.yaml";
}

}  // namespace

SimulationNodeConfig readSimulatedScene(const std::string& simulation_file,
                                        const std::vector<std::string>& scene_files, int seed) {
  ros::Time::init();  // there is no node: the time is the wall's
  std::vector<std::string> files{simulation_file.empty() ? packagedSimulation() : simulation_file};
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
