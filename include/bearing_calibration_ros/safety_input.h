#pragma once

#include <ros/node_handle.h>
#include <ros/time.h>
#include <std_msgs/Bool.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/drive_params.h"
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

/// All that forbids to drive: both inputs with their subscriptions, and the end of the process.
class SafetyInputs {
 public:
  /// Is told of a no at once.
  using OnNo = std::function<void(core::DriveEnd)>;

  SafetyInputs(ros::NodeHandle node_handle, ros::NodeHandle private_node_handle,
               const DriveNodeConfig& config, const OnNo& on_no)
      : enable_({core::DriveEnd::kDisabled, core::DriveEnd::kEnableLost}, config.enable_timeout_s,
                config.enable_required),
        obstacle_({core::DriveEnd::kObstacle, core::DriveEnd::kObstacleLost},
                  config.obstacle_timeout_s, false),
        enable_subscriber_(subscribe(private_node_handle, "enable", true, &enable_, on_no)),
        obstacle_subscriber_(subscribe(node_handle, "obstacle", false, &obstacle_, on_no)) {}

  /// Why the robot must not drive now; kNone when it may.
  core::DriveEnd objection() const {
    if (is_shut_down_) return core::DriveEnd::kShutDown;
    const ros::SteadyTime now = ros::SteadyTime::now();
    const core::DriveEnd obstacle = obstacle_.objection(now);
    return obstacle != core::DriveEnd::kNone ? obstacle : enable_.objection(now);
  }
  /// Looks for publishers that have to speak from now on.
  void seePublishers() {
    const ros::SteadyTime now = ros::SteadyTime::now();
    if (enable_subscriber_.getNumPublishers() > 0) enable_.seePublisher(now);
    if (obstacle_subscriber_.getNumPublishers() > 0) obstacle_.seePublisher(now);
  }
  /// No drive any more. For another thread.
  void shutDown() { is_shut_down_ = true; }

 private:
  /// @param allowing  what the topic says where the robot may drive
  static ros::Subscriber subscribe(ros::NodeHandle& node_handle, const std::string& topic,
                                   bool allowing, SafetyInput* input, const OnNo& on_no) {
    constexpr std::uint32_t kQueue = 10;
    return node_handle.subscribe<std_msgs::Bool>(
        topic, kQueue,
        [=](const std_msgs::BoolConstPtr& message) {
          const ros::SteadyTime now = ros::SteadyTime::now();
          const bool is_allowed = (message->data != 0) == allowing;
          input->hear(is_allowed, now);
          if (!is_allowed) on_no(input->objection(now));
        },
        {}, ros::TransportHints().tcpNoDelay());
  }

  std::atomic<bool> is_shut_down_{false};
  SafetyInput enable_, obstacle_;
  ros::Subscriber enable_subscriber_, obstacle_subscriber_;
};

}  // namespace bearing_calibration_ros
