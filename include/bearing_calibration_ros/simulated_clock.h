#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include <chrono>
#include <condition_variable>
#include <mutex>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// Makes the simulation's steps happen in time: in wall time, or in a time of its own that is sent
/// to /clock and runs faster or slower. One thread waits; stop() may be called from another.
class SimulatedClock {
 public:
  SimulatedClock(ros::NodeHandle node_handle, const SimulatedClockConfig& config);

  /// Stamp of the simulation's beginning.
  core::Stamp start() const { return start_; }

  /// Waits until it is `stamp` and sends it to /clock, if that is wanted. False when stopped.
  bool waitUntil(core::Stamp stamp);
  void stop();

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
