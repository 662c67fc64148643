#include "bearing_calibration_ros/input_watch.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration_ros {

bool ClockWatch::hasJumpedBack(const ros::Time& now, double max_step_back_s) {
  const bool jumped = now + ros::Duration(max_step_back_s) < latest_;
  latest_ = jumped ? now : std::max(latest_, now);
  return jumped;
}

bool StampWatch::hasBegunAnew(const core::InputOutcome& outcome, core::Stamp stamp,
                              double max_step_back_s) {
  constexpr int kEnoughInARow = 20;  // 0.2 s of encoders at 100 Hz; a burst in disorder is shorter
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

void SilenceWatch::saw(double now_s) {
  constexpr double kForget = 0.5;  // of a longer one, with each that comes
  if (last_s_) interval_s_ = std::max(now_s - *last_s_, kForget * interval_s_);
  last_s_ = now_s;
}

bool SilenceWatch::isSilent(double now_s) const {
  constexpr double kIntervals = 3.0;
  constexpr double kLeast_s = 2.0;  // a moment's stall is none
  return !last_s_ || now_s - *last_s_ > std::max(kLeast_s, kIntervals * interval_s_);
}

InputWatch::InputWatch(const std::string& wheel_topic, const std::string& bearing_topic,
                       double timeout_s)
    : wheels_{wheel_topic, {}}, bearings_{bearing_topic, {}}, timeout_(timeout_s) {}

bool InputWatch::isAlive(const Stream& stream, const ros::Time& now) const {
  return !stream.last.isZero() && now - stream.last <= timeout_;
}

std::string InputWatch::sentence(const Stream& stream, const ros::Time& now) const {
  if (stream.last.isZero()) return "nothing has come on " + stream.topic + " yet";
  const auto silent_s = std::llround((now - stream.last).toSec());
  return "nothing has come on " + stream.topic + " for " + std::to_string(silent_s) + " s";
}

std::string InputWatch::silence(const ros::Time& now) {
  if (watching_since_.isZero()) watching_since_ = now;
  if (now - watching_since_ <= timeout_) return {};
  const bool wheels_alive = isAlive(wheels_, now);
  const bool bearings_alive = isAlive(bearings_, now);
  if (wheels_alive && bearings_alive) return {};
  if (wheels_alive) return "wheel readings without bearings: " + sentence(bearings_, now);
  if (bearings_alive) return "bearings without wheel readings: " + sentence(wheels_, now);
  return "no input: " + sentence(wheels_, now) + ", " + sentence(bearings_, now);
}

void InputWatch::restart() { wheels_.last = bearings_.last = watching_since_ = ros::Time(); }

}  // namespace bearing_calibration_ros
