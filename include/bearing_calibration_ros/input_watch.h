#pragma once

#include <ros/time.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Notices that a clock has jumped back: a bag that loops, a simulation that starts anew. Smaller
/// steps are lived through: those of network time, and threads that read a running clock in any
/// order.
class ClockWatch {
 public:
  /// @returns true once for each jump of ROS time back by more than the limit.
  bool hasJumpedBack(const ros::Time& now, double max_step_back_s) {
    const bool jumped = now + ros::Duration(max_step_back_s) < latest_;
    latest_ = jumped ? now : std::max(latest_, now);
    return jumped;
  }

 private:
  ros::Time latest_;
};

/// Notices that a sensor's stamps have begun anew while ROS time went on: a bag that loops without
/// --clock. One late reading is no such thing: many in a row are, when they follow each other. Nor
/// is a step back by less than the limit: readings are refused until they overtake the last one.
class StampWatch {
 public:
  /// Tells about the next reading of the stream; @returns true once for each new beginning.
  bool hasBegunAnew(const core::InputOutcome& outcome, core::Stamp stamp, double max_step_back_s) {
    constexpr int kEnoughInARow =
        20;  // 0.2 s of encoders at 100 Hz; a burst in disorder is shorter
    const bool follows = refused_in_a_row_ == 0 || stamp > last_refused_;
    if (outcome.status != core::InputStatus::kStampNotAfterLast || !follows) {
      refused_in_a_row_ = 0;
      return false;
    }
    if (refused_in_a_row_ == 0) step_back_s_ = outcome.value;
    last_refused_ = stamp;
    if (++refused_in_a_row_ < kEnoughInARow || step_back_s_ <= max_step_back_s) return false;
    refused_in_a_row_ = 0;
    return true;
  }

 private:
  int refused_in_a_row_ = 0;
  core::Stamp last_refused_;
  double step_back_s_ = 0.0;  ///< of the first one in the row
};

/// Notices that a stream has ended, whatever its rate: its silence is far longer than the intervals
/// before it. All times are of one clock that never jumps, in seconds.
class SilenceWatch {
 public:
  void saw(double now_s) {
    constexpr double kForget = 0.5;  // of a longer one, with each that comes
    if (last_s_) interval_s_ = std::max(now_s - *last_s_, kForget * interval_s_);
    last_s_ = now_s;
  }
  bool isSilent(double now_s) const {
    constexpr double kIntervals = 3.0;
    constexpr double kLeast_s = 2.0;  // a moment's stall is none
    return !last_s_ || now_s - *last_s_ > std::max(kLeast_s, kIntervals * interval_s_);
  }

 private:
  std::optional<double> last_s_;
  double interval_s_ = 1.0;  ///< the longest of late; at first, a guess
};

/// Notices that an input is silent. All times are ROS time.
class InputWatch {
 public:
  InputWatch(const std::string& wheel_topic, const std::string& bearing_topic, double timeout_s)
      : wheels_{wheel_topic, {}}, bearings_{bearing_topic, {}}, timeout_(timeout_s) {}

  void sawWheels(const ros::Time& now) { wheels_.last = now; }
  void sawBearings(const ros::Time& now) { bearings_.last = now; }
  bool areWheelsAlive(const ros::Time& now) const { return isAlive(wheels_, now); }

  /// One sentence for the input that is silent, with its topic; empty when none is.
  std::string silence(const ros::Time& now) {
    if (watching_since_.isZero()) watching_since_ = now;
    if (now - watching_since_ <= timeout_) return {};
    const bool wheels_alive = isAlive(wheels_, now);
    const bool bearings_alive = isAlive(bearings_, now);
    if (wheels_alive && bearings_alive) return {};
    if (wheels_alive) return "wheel readings without bearings: " + silenceOf(bearings_, now);
    if (bearings_alive) return "bearings without wheel readings: " + silenceOf(wheels_, now);
    return "no input: " + silenceOf(wheels_, now) + ", " + silenceOf(bearings_, now);
  }

  /// The clock has begun anew.
  void restart() { wheels_.last = bearings_.last = watching_since_ = ros::Time(); }

 private:
  struct Stream {
    std::string topic;
    ros::Time last;  ///< zero: never
  };
  bool isAlive(const Stream& stream, const ros::Time& now) const {
    return !stream.last.isZero() && now - stream.last <= timeout_;
  }
  static std::string silenceOf(const Stream& stream, const ros::Time& now) {
    const std::string nothing = "nothing has come on " + stream.topic;
    if (stream.last.isZero()) return nothing + " yet";
    return nothing + " for " + std::to_string(std::llround((now - stream.last).toSec())) + " s";
  }

  Stream wheels_;
  Stream bearings_;
  ros::Duration timeout_;
  ros::Time watching_since_;  ///< zero: not yet
};

}  // namespace bearing_calibration_ros
