#pragma once

#include <ros/time.h>

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
  bool hasJumpedBack(const ros::Time& now, double max_step_back_s);

 private:
  ros::Time latest_;
};

/// Notices that a sensor's stamps have begun anew while ROS time went on: a bag that loops without
/// --clock. One late reading is no such thing: many in a row are, when they follow each other. Nor
/// is a step back by less than the limit: readings are refused until they overtake the last one.
class StampWatch {
 public:
  /// Tells about the next reading of the stream; @returns true once for each new beginning.
  bool hasBegunAnew(const core::InputOutcome& outcome, core::Stamp stamp, double max_step_back_s);

 private:
  int refused_in_a_row_ = 0;
  core::Stamp last_refused_;
  double step_back_s_ = 0.0;  ///< of the first one in the row
};

/// Notices that a stream has ended, whatever its rate: its silence is far longer than the intervals
/// before it. All times are of one clock that never jumps, in seconds.
class SilenceWatch {
 public:
  void saw(double now_s);
  bool isSilent(double now_s) const;

 private:
  std::optional<double> last_s_;
  double interval_s_ = 1.0;  ///< the longest of late; at first, a guess
};

/// Notices that an input is silent. All times are ROS time.
class InputWatch {
 public:
  InputWatch(const std::string& wheel_topic, const std::string& bearing_topic, double timeout_s);

  void sawWheels(const ros::Time& now) { wheels_.last = now; }
  void sawBearings(const ros::Time& now) { bearings_.last = now; }
  bool areWheelsAlive(const ros::Time& now) const { return isAlive(wheels_, now); }

  /// One sentence for the input that is silent, with its topic; empty when none is.
  std::string silence(const ros::Time& now);

  /// The clock has begun anew.
  void restart();

 private:
  struct Stream {
    std::string topic;
    ros::Time last;  ///< zero: never
  };
  bool isAlive(const Stream& stream, const ros::Time& now) const;
  std::string sentence(const Stream& stream, const ros::Time& now) const;

  Stream wheels_;
  Stream bearings_;
  ros::Duration timeout_;
  ros::Time watching_since_;  ///< zero: not yet
};

}  // namespace bearing_calibration_ros
