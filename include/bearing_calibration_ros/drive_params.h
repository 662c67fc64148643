#pragma once

#include <ros/duration.h>

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>

#include "bearing_calibration/input/bearing_input.h"
#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/sensor_places.h"
#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration_ros {

/// Everything that the drive nodelet reads from its private parameters: config/drive.yaml, and the
/// groups `wheels` and `bearings` of config/calibration.yaml.
struct DriveNodeConfig {
  WheelInput wheels;
  core::DriveGeometry geometry;
  core::WheelTimes wheel_times;
  core::BearingInputConfig bearings;  ///< of which a drive asks for the least probability alone
  core::DriveConfig drive;
  core::DriveGoal default_goal;     ///< what a goal does not name
  double clock_timeout_s = 0.0;     ///< of real time in which ROS time may stand still
  double enable_timeout_s = 0.0;    ///< of real time in which ~enable may be silent; 0: for ever
  double obstacle_timeout_s = 0.0;  ///< ... and obstacle
  bool enable_required = false;     ///< nothing moves before the first ~enable
  double control_rate_hz = 0.0;     ///< in real time
  std::string start_frame;          ///< of the published paths

  /// For so long a process that is asked to end waits until the robot has braked.
  ros::WallDuration longestStop() const {
    constexpr double kMargin_s = 1.0;    // the control's period, and what a busy machine adds
    constexpr double kLongest_s = 10.0;  // roslaunch kills after 15 s
    const double braking_s = drive.limits.max_speed_mps / drive.limits.max_acceleration_mps2;
    return ros::WallDuration(std::min(braking_s + kMargin_s, kLongest_s));
  }

  void declare(core::Parameters& params) {
    constexpr double kLeastControl_hz = 1.0;
    constexpr double kMostControl_hz = 1000.0;
    constexpr double kLongestSilence_s = 60.0;  // a longer one is no dead man's button
    using core::DriveGoal, core::plausible::kBriefest_s, core::plausible::kLongest_s;
    wheels.declare(params);
    geometry.declare(params);
    wheel_times.declare(params);
    bearings.declare(params);
    drive.min_probability = bearings.min_probability;
    drive.limits.wheel_separation_m = geometry.wheel_separation_m;
    drive.declare(params);
    params.that(drive.limits.max_speed_mps <= geometry.max_wheel_speed_mps,
                "limits/wheel_speed must not be greater than wheels/max_speed: faster readings are "
                "refused");
    params.choice("drive/motion", core::motionNames(), default_goal.motion);
    params.number("drive/max_time", default_goal.max_time_s, DriveGoal::kLeastTime_s,
                  DriveGoal::kMostTime_s);
    params.number("drive/max_path", default_goal.max_path_m, DriveGoal::kLeastPath_m,
                  DriveGoal::kMostPath_m);
    params.number("timeouts/enable", enable_timeout_s, 0.0, kLongestSilence_s);
    params.number("timeouts/obstacle", obstacle_timeout_s, 0.0, kLongestSilence_s);
    params.number("timeouts/clock", clock_timeout_s, kBriefest_s, kLongest_s);
    params.read("enable/required", enable_required);
    params.number("drive/control_rate", control_rate_hz, kLeastControl_hz, kMostControl_hz);
    declareFrame("drive/start_frame", start_frame, params);
  }
};

/// The drive that somebody asks for, with the defaults for what is not named.
/// @throws std::invalid_argument for an unknown motion or a budget out of its bounds.
inline core::DriveGoal goalFrom(const std::string& motion, double max_time_s, double max_path_m,
                                const core::DriveGoal& default_goal) {
  core::DriveGoal goal = default_goal;
  if (!motion.empty()) {
    const std::optional<core::DriveMotion> named = core::motionNamed(motion);
    if (!named) {
      throw std::invalid_argument("motion must be optimal, dance or corner_light, but is '" +
                                  motion + "'");
    }
    goal.motion = *named;
  }
  if (max_time_s != 0.0) goal.max_time_s = max_time_s;
  if (max_path_m != 0.0) goal.max_path_m = max_path_m;
  return core::validated(goal);
}

}  // namespace bearing_calibration_ros
