#pragma once

#include <ros/time.h>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// A topic that says again and again whether the robot may drive: a dead man's button, a bumper.
/// Its silence forbids to drive as its no does, as soon as somebody was there to publish it.
class SafetyInput {
 public:
  /// What is objected when the topic says no, and when it is silent.
  struct Ends {
    core::DriveEnd says_no, is_silent;
  };

  /// @param timeout_s  of silence; 0: the last message holds for ever
  /// @param is_required  nothing is allowed before the first message
  SafetyInput(const Ends& ends, double timeout_s, bool is_required)
      : ends_(ends), timeout_(timeout_s), is_required_(is_required) {}

  void hear(bool allows, const ros::SteadyTime& now) {
    allows_ = allows;
    is_heard_ = true;
    last_ = now;
  }

  /// A publisher has connected: it has to speak from now on.
  void seePublisher(const ros::SteadyTime& now) {
    if (last_.isZero()) last_ = now;
  }

  /// @returns why the robot must not drive; kNone when it may.
  core::DriveEnd objection(const ros::SteadyTime& now) const {
    if (!allows_) return ends_.says_no;
    const bool is_late = !timeout_.isZero() && !last_.isZero() && now - last_ > timeout_;
    const bool is_missing = is_required_ && !is_heard_;
    return is_late || is_missing ? ends_.is_silent : core::DriveEnd::kNone;
  }

 private:
  Ends ends_;
  ros::WallDuration timeout_;
  bool is_required_;
  bool allows_ = true;
  bool is_heard_ = false;
  ros::SteadyTime last_;  ///< zero: nobody was there yet
};

}  // namespace bearing_calibration_ros
