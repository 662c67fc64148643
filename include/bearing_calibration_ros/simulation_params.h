#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration/simulation/trajectory.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// Parameter group `clock`.
struct SimulatedClockConfig {
  bool publish = false;  ///< time is the simulation's own, sent to /clock; else it is wall time
  double rate = 1.0;     ///< simulated seconds in a second, when published

  std::vector<std::string> validate() const;
};

/// Parameter group `trajectory`.
struct DrivingConfig {
  bool follows_commands = false;  ///< of cmd_vel; else drives `trajectory`
  core::TrajectoryConfig trajectory;
  double duration_s = 0.0;         ///< the robot stands still afterwards; 0 is without end
  bool stops_at_end = false;       ///< and the simulation falls silent
  double command_timeout_s = 0.0;  ///< a command older than this no longer moves the robot

  std::vector<std::string> validate() const;
};

/// Parameter group `frames`.
struct SimulatedFrames {
  std::string world;
  std::string base;
  std::string sensor;

  std::vector<std::string> validate() const;
};

/// Everything that the simulation nodelet reads from its private parameters.
struct SimulationNodeConfig {
  SimulatedClockConfig clock;
  SimulatedFrames frames;
  DrivingConfig driving;
  core::RobotConfig robot;
  double mount_height_m = 0.0;  ///< of the sensor over the base frame
  core::SceneConfig scene;
  core::RendererConfig renderer;  ///< its holders are drawn with the scene
  std::uint64_t seed = 0;         ///< of the scene and of every noise
};

/// Reads config/simulation.yaml's parameters.
/// @throws std::runtime_error with one line for each parameter that is missing, wrong or unknown.
SimulationNodeConfig readSimulationNodeConfig(ParamReader params);

}  // namespace bearing_calibration_ros
