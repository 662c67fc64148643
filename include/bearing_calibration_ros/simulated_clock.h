#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// Makes the simulation's steps happen in time: in wall time, or in a time of its own that is sent
/// to /clock and runs faster or slower. One thread waits; stop() may be called from another.
class SimulatedClock {
 public:
  SimulatedClock(ros::NodeHandle node_handle, const SimulatedClockConfig& config)
      : config_(config), wall_start_(WallClock::now()) {
    constexpr double kSimulatedStart_s = 1.0;  // zero means "no time yet" in ROS
    constexpr std::uint32_t kClockQueue = 10;  // whoever falls behind needs the newest alone
    start_ =
        config.publish ? core::stampFromSeconds(kSimulatedStart_s) : stampFromRos(ros::Time::now());
    if (config.publish) {
      publisher_ = node_handle.advertise<rosgraph_msgs::Clock>("/clock", kClockQueue);
    }
  }

  /// Stamp of the simulation's beginning.
  core::Stamp start() const { return start_; }

  /// Waits until it is `stamp` and sends it to /clock, if that is wanted. False when stopped.
  bool waitUntil(core::Stamp stamp) {
    const double rate = config_.publish ? config_.rate : 1.0;
    const double wall_s = core::secondsFromDuration(stamp - start_) / rate;
    const auto due = wall_start_ + core::durationFromSeconds(wall_s);
    std::unique_lock<std::mutex> lock(mutex_);
    if (stopped_.wait_until(lock, due, [this] { return is_stopped_; })) return false;
    if (config_.publish) {
      rosgraph_msgs::Clock message;
      message.clock = rosFromStamp(stamp);
      publisher_.publish(message);
      // Time lost to a busy machine stays lost: a simulated time need not catch up.
      wall_start_ += std::max(WallClock::now() - due, WallClock::duration::zero());
    }
    return true;
  }

  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
    stopped_.notify_all();
  }

 private:
  using WallClock = std::chrono::steady_clock;

  SimulatedClockConfig config_;
  core::Stamp start_;
  WallClock::time_point wall_start_;
  ros::Publisher publisher_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool is_stopped_ = false;  ///< under mutex_
};

}  // namespace bearing_calibration_ros
