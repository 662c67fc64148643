#pragma once

#include <cstdint>
#include <string>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration/simulation/trajectory_config.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// Parameter group `clock`.
struct SimulatedClockConfig {
  bool publish = false;  ///< time is the simulation's own, sent to /clock; else it is wall time
  double rate = 1.0;     ///< simulated seconds in a second, when published

  void declare(core::Parameters& params);
};

/// Parameter group `trajectory`.
struct DrivingConfig {
  bool follows_commands = false;  ///< of cmd_vel; else drives `trajectory`
  core::TrajectoryConfig trajectory;
  double duration_s = 0.0;         ///< the robot stands still afterwards; 0 is without end
  bool stops_at_end = false;       ///< and the simulation falls silent
  double command_timeout_s = 0.0;  ///< a command older than this no longer moves the robot

  void declare(core::Parameters& params);
};

/// Parameter group `frames`.
struct SimulatedFrames {
  std::string world;
  std::string base;
  std::string sensor;

  void declare(core::Parameters& params);
};

/// Everything that the simulation nodelet reads from its private parameters:
/// config/simulation.yaml.
struct SimulationNodeConfig {
  SimulatedClockConfig clock;
  SimulatedFrames frames;
  DrivingConfig driving;
  core::RobotConfig robot;
  double mount_height_m = 0.0;  ///< of the sensor over the base frame
  core::SceneConfig scene;
  core::RendererConfig renderer;  ///< its holders are drawn with the scene
  std::uint64_t seed = 0;         ///< of the scene and of every noise

  void declare(core::Parameters& params);
};

}  // namespace bearing_calibration_ros
