#pragma once

#include <string>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/wheel_params.h"

namespace bearing_calibration_ros {

/// Everything that the drive nodelet reads from its private parameters: config/drive.yaml, and the
/// group `wheels` of config/calibration.yaml.
struct DriveNodeConfig {
  WheelInput wheels;
  core::DriveGeometry geometry;
  core::WheelTimes wheel_times;
  core::DriveConfig drive;
  core::DriveGoal default_goal;     ///< what a goal does not name
  double clock_timeout_s = 0.0;     ///< of real time in which ROS time may stand still
  double enable_timeout_s = 0.0;    ///< of real time in which ~enable may be silent; 0: for ever
  double obstacle_timeout_s = 0.0;  ///< ... and obstacle
  bool enable_required = false;     ///< nothing moves before the first ~enable
  double control_rate_hz = 0.0;     ///< in real time
  std::string start_frame;          ///< of the published paths

  void declare(core::Parameters& params);
};

/// The drive that somebody asks for, with the defaults for what is not named.
/// @throws std::invalid_argument for an unknown motion or a budget out of its bounds.
core::DriveGoal goalFrom(const std::string& motion, double max_time_s, double max_path_m,
                         const core::DriveGoal& default_goal);

}  // namespace bearing_calibration_ros
