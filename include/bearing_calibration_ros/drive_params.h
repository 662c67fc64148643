#pragma once

#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/wheel_params.h"

namespace bearing_calibration_ros {

/// Everything that the drive nodelet reads from its private parameters.
struct DriveNodeConfig {
  WheelParams wheels;
  core::DriveConfig drive;
  core::DriveGoal default_goal;     ///< what a goal does not name
  double clock_timeout_s = 0.0;     ///< of real time in which ROS time may stand still
  double enable_timeout_s = 0.0;    ///< of real time in which ~enable may be silent; 0: for ever
  double obstacle_timeout_s = 0.0;  ///< ... and obstacle
  bool enable_required = false;     ///< nothing moves before the first ~enable
  double control_rate_hz = 0.0;     ///< in real time
  std::string start_frame;          ///< of the published paths

  std::vector<std::string> validate() const;
};

/// Reads config/drive.yaml's parameters and the group `wheels` of config/calibration.yaml.
/// @throws std::runtime_error with one line for each parameter that is missing, wrong or unknown.
DriveNodeConfig readDriveNodeConfig(ParamReader params);

/// The drive that somebody asks for, with the defaults for what is not named.
/// @throws std::invalid_argument for an unknown motion or a budget out of its bounds.
core::DriveGoal goalFrom(const std::string& motion, double max_time_s, double max_path_m,
                         const core::DriveGoal& default_goal);

}  // namespace bearing_calibration_ros
