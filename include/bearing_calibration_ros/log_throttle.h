#pragma once

#include <ros/time.h>

#include <map>
#include <string>

namespace bearing_calibration_ros {

/// Lets a message of each kind through once in a while. Unlike the *_THROTTLE macros it knows kinds
/// apart, so that one fault does not hide another, and it goes by a clock that always runs: with
/// simulated time those say nothing before /clock begins.
class LogThrottle {
 public:
  explicit LogThrottle(double period_s) : period_(period_s) {}

  bool isDue(const std::string& kind, ros::SteadyTime now = ros::SteadyTime::now()) {
    const auto [last, is_first] = last_.try_emplace(kind, now);
    if (!is_first && now - last->second < period_) return false;
    last->second = now;
    return true;
  }

 private:
  ros::WallDuration period_;
  std::map<std::string, ros::SteadyTime> last_;
};

}  // namespace bearing_calibration_ros
