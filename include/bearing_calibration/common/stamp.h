#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace bearing_calibration::core {

/// The clock that the sensors stamp with: nanoseconds since an epoch of their own. It cannot be
/// read (there is no now()): the core is told the time with each measurement.
struct SensorClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<SensorClock, duration>;
  static constexpr bool is_steady = false;
};

using Stamp = SensorClock::time_point;
using Duration = SensorClock::duration;

/// Seconds -> the nearest nanosecond.
inline Duration durationFromSeconds(double seconds) {
  return Duration(std::llround(seconds * 1e9));
}
inline double secondsFromDuration(Duration duration) {
  return std::chrono::duration<double>(duration).count();
}
inline Stamp stampFromNanoseconds(std::int64_t nanoseconds) { return Stamp(Duration(nanoseconds)); }
inline Stamp stampFromSeconds(double seconds) { return Stamp(durationFromSeconds(seconds)); }

/// ROS stamps a message that nobody stamped with zero: no moment at all.
inline bool isStamped(Stamp stamp) { return stamp.time_since_epoch() > Duration::zero(); }

}  // namespace bearing_calibration::core
