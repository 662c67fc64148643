#include "bearing_calibration/odometry/wheel_pairing.h"

#include <cmath>

#include "bearing_calibration/odometry/wheel_odometer.h"

namespace bearing_calibration::core {
namespace {

/// How long the stamps of a queue go on after its first one [s].
double extent(const std::deque<WheelCount>& readings) {
  return secondsFromDuration(readings.back().stamp - readings.front().stamp);
}

}  // namespace

PairingOutcome WheelPairing::add(WheelSide side, const WheelCount& reading) {
  PairingOutcome outcome;
  if (const auto refusal = refusalOf(side, reading)) {
    outcome.refused.push_back(*refusal);
    return outcome;
  }
  if (side == WheelSide::kLeft) {
    left_.push_back(reading);
    newest_left_ = reading.stamp;
  } else {
    right_.push_back(reading);
  }
  pairWhatIsCovered(&outcome);
  refuseWhatWaitsTooLong(&outcome);
  return outcome;
}

std::optional<InputOutcome> WheelPairing::refusalOf(WheelSide side,
                                                    const WheelCount& reading) const {
  if (!isStamped(reading.stamp)) return InputOutcome{InputStatus::kNoStamp, 0.0};
  if (!fitsCounter(reading.ticks, counter_bits_)) {
    return InputOutcome{InputStatus::kTicksOutOfRange, static_cast<double>(reading.ticks)};
  }
  std::optional<Stamp> last = newest_left_;
  if (side == WheelSide::kRight) {
    last = right_.empty() ? std::nullopt : std::optional(right_.back().stamp);
  }
  if (!last || reading.stamp > *last) return std::nullopt;
  return InputOutcome{InputStatus::kStampNotAfterLast, secondsFromDuration(*last - reading.stamp)};
}

void WheelPairing::pairWhatIsCovered(PairingOutcome* outcome) {
  while (!left_.empty() && !right_.empty() && left_.front().stamp <= right_.back().stamp) {
    const WheelCount left = left_.front();
    left_.pop_front();
    while (right_.size() > 1 && right_[1].stamp <= left.stamp) right_.pop_front();
    if (left.stamp < right_.front().stamp) continue;  // before the first right reading: no news
    const double apart_s = right_.front().stamp == left.stamp
                               ? 0.0
                               : secondsFromDuration(right_[1].stamp - right_.front().stamp);
    if (apart_s > max_apart_s_) {
      outcome->refused.push_back({InputStatus::kNoPartner, apart_s});
    } else {
      outcome->pairs.push_back(pairAt(left));
    }
  }
}

void WheelPairing::refuseWhatWaitsTooLong(PairingOutcome* outcome) {
  while (!left_.empty() && extent(left_) > kLongestWait_s) {
    outcome->refused.push_back({InputStatus::kNoPartner, extent(left_)});
    left_.pop_front();
  }
  while (!right_.empty() && extent(right_) > kLongestWait_s) {
    outcome->refused.push_back({InputStatus::kNoPartner, extent(right_)});
    right_.pop_front();
  }
}

WheelCounts WheelPairing::pairAt(const WheelCount& left) const {
  const WheelCount& before = right_.front();
  if (before.stamp == left.stamp) return {left.stamp, left.ticks, before.ticks};
  const WheelCount& after = right_[1];
  const double share = secondsFromDuration(left.stamp - before.stamp) /
                       secondsFromDuration(after.stamp - before.stamp);
  const auto way =
      static_cast<double>(wrappedTickDifference(before.ticks, after.ticks, counter_bits_));
  const std::int64_t right_ticks = before.ticks + std::llround(share * way);
  return {left.stamp, left.ticks, wrappedTickDifference(0, right_ticks, counter_bits_)};
}

}  // namespace bearing_calibration::core
