#include "tools/owner/simulated_scene.h"

#include <ros/time.h>

#include <stdexcept>

#include "bearing_calibration_ros/parameter_files.h"

namespace bearing_calibration_ros {
namespace {

void requireNotNegative(int seed) {
  if (seed < 0) throw boost::program_options::error("--seed must not be negative");
}

}  // namespace

void SceneArguments::addTo(boost::program_options::options_description* description) {
  namespace options = boost::program_options;
  auto add = description->add_options();
  add("scene", options::value(&scene_files)->composing(),
      "YAML file of parameters that replace the simulation's, as config/scene.yaml");
  add("simulation", options::value(&simulation_file),
      "YAML file of all parameters of the simulation (the package's config/simulation.yaml)");
  add("seed", options::value(&seed)->notifier(requireNotNegative),
      "in place of world/seed, 0 or more");
}

SimulationNodeConfig readSimulatedScene(const SceneArguments& arguments) {
  ros::Time::init();  // there is no node: the time is the wall's
  std::vector<std::string> files{arguments.simulation_file.empty()
                                     ? packagedConfig("simulation.yaml")
                                     : arguments.simulation_file};
  files.insert(files.end(), arguments.scene_files.begin(), arguments.scene_files.end());
  ParameterMap parameters = parametersFromFiles(files);
  if (arguments.seed >= 0) parameters["world/seed"] = arguments.seed;
  SimulationNodeConfig config = readConfig<SimulationNodeConfig>(ParamReader(parameters));
  if (config.driving.follows_commands) {
    throw std::runtime_error("trajectory/kind is cmd_vel: nobody gives commands here");
  }
  return config;
}

}  // namespace bearing_calibration_ros
