#include "bearing_calibration_ros/simulated_clock.h"

#include <rosgraph_msgs/Clock.h>

#include <algorithm>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

constexpr double kSimulatedStart_s = 1.0;  // zero means "no time yet" in ROS
constexpr std::uint32_t kClockQueue = 10;  // whoever falls behind needs the newest alone

}  // namespace

SimulatedClock::SimulatedClock(ros::NodeHandle node_handle, const SimulatedClockConfig& config)
    : config_(config),
      start_(config.publish ? core::stampFromSeconds(kSimulatedStart_s)
                            : stampFromRos(ros::Time::now())),
      wall_start_(WallClock::now()) {
  if (config.publish) {
    publisher_ = node_handle.advertise<rosgraph_msgs::Clock>("/clock", kClockQueue);
  }
}

bool SimulatedClock::waitUntil(core::Stamp stamp) {
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

void SimulatedClock::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_stopped_ = true;
  stopped_.notify_all();
}

}  // namespace bearing_calibration_ros
