#include "bearing_calibration/odometry/wheel_readings.h"

#include <cmath>

namespace bearing_calibration::core {

std::int64_t wrappedTickDifference(std::int64_t from_ticks, std::int64_t to_ticks, int bits) {
  const int unused_bits = 64 - bits;
  const std::uint64_t difference =
      static_cast<std::uint64_t>(to_ticks) - static_cast<std::uint64_t>(from_ticks);
  return static_cast<std::int64_t>(difference << unused_bits) >> unused_bits;  // extends the sign
}

bool fitsCounter(std::int64_t ticks, int bits) {
  if (bits == 64) return true;
  const std::int64_t range = std::int64_t{1} << bits;
  return ticks >= -range / 2 && ticks < range;
}

PairingOutcome WheelPairing::add(WheelSide side, const WheelCount& reading) {
  Stream& stream = side == WheelSide::kLeft ? left_ : right_;
  const InputOutcome checked = check(reading, stream.newest);
  if (!checked.accepted()) return {{}, {checked}};
  stream.waiting.push_back(reading);
  stream.newest = reading.stamp;
  PairingOutcome outcome;
  pairWhatIsCovered(&outcome);
  for (std::deque<WheelCount>* waiting : {&left_.waiting, &right_.waiting}) {
    while (!waiting->empty()) {
      const double waited_s = secondsFromDuration(waiting->back().stamp - waiting->front().stamp);
      if (waited_s <= kLongestWait_s) break;
      outcome.refused.push_back({InputStatus::kNoPartner, waited_s});
      waiting->pop_front();
    }
  }
  return outcome;
}

InputOutcome WheelPairing::check(const WheelCount& reading,
                                 const std::optional<Stamp>& newest) const {
  if (!isStamped(reading.stamp)) return {InputStatus::kNoStamp, 0.0};
  if (!fitsCounter(reading.ticks, counter_bits_)) {
    return {InputStatus::kTicksOutOfRange, static_cast<double>(reading.ticks)};
  }
  if (newest && reading.stamp <= *newest) {
    return {InputStatus::kStampNotAfterLast, secondsFromDuration(*newest - reading.stamp)};
  }
  return {};
}

void WheelPairing::pairWhatIsCovered(PairingOutcome* outcome) {
  std::deque<WheelCount>& lefts = left_.waiting;
  std::deque<WheelCount>& rights = right_.waiting;
  for (; !lefts.empty() && !rights.empty() && lefts.front().stamp <= rights.back().stamp;
       lefts.pop_front()) {
    const WheelCount& left = lefts.front();
    while (rights.size() > 1 && rights[1].stamp <= left.stamp) rights.pop_front();
    const WheelCount& before = rights.front();
    if (left.stamp < before.stamp) continue;  // before the first right reading: no news
    if (left.stamp == before.stamp) {
      outcome->pairs.push_back({left.stamp, left.ticks, before.ticks});
      continue;
    }
    const WheelCount& after = rights[1];
    const double apart_s = secondsFromDuration(after.stamp - before.stamp);
    if (apart_s > max_apart_s_) {
      outcome->refused.push_back({InputStatus::kNoPartner, apart_s});
      continue;
    }
    const double share = secondsFromDuration(left.stamp - before.stamp) / apart_s;
    const auto way = wrappedTickDifference(before.ticks, after.ticks, counter_bits_);
    const std::int64_t rolled = std::llround(share * static_cast<double>(way));
    outcome->pairs.push_back(
        {left.stamp, left.ticks, wrappedTickDifference(-rolled, before.ticks, counter_bits_)});
  }
}

}  // namespace bearing_calibration::core
