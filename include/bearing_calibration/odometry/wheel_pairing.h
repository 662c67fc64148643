#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/odometry/wheel_readings.h"

namespace bearing_calibration::core {

enum class WheelSide : std::uint8_t { kLeft, kRight };

/// The counter of one wheel: cumulative, wrapping at its width, at times reset by its driver.
struct WheelCount {
  Stamp stamp;
  std::int64_t ticks = 0;
};

/// What one reading of a wheel led to.
struct PairingOutcome {
  std::vector<WheelCounts> pairs;     ///< that it completed, oldest first
  std::vector<InputOutcome> refused;  ///< it, or readings that have waited in vain
};

/// The counters of two wheels that come one by one, to counts of both at one moment: that of each
/// left reading, with the right counter interpolated between the readings around it. So the two
/// need not be read at the same time, and a constant speed makes no error.
///
/// A left reading waits for the right one after it. It is refused where the right readings around
/// it lie too far apart, or when none has come for kLongestWait_s of its own stream; right readings
/// without left ones are refused in the same way.
class WheelPairing {
 public:
  /// @param max_apart_s  between two right readings with left ones between them
  WheelPairing(int counter_bits, double max_apart_s)
      : counter_bits_(counter_bits), max_apart_s_(max_apart_s) {}

  PairingOutcome add(WheelSide side, const WheelCount& reading);

  static constexpr double kLongestWait_s = 5.0;

 private:
  std::optional<InputOutcome> refusalOf(WheelSide side, const WheelCount& reading) const;
  void pairWhatIsCovered(PairingOutcome* outcome);
  void refuseWhatWaitsTooLong(PairingOutcome* outcome);
  WheelCounts pairAt(const WheelCount& left) const;

  int counter_bits_;
  double max_apart_s_;
  std::deque<WheelCount> left_;       ///< that wait for a right reading
  std::deque<WheelCount> right_;      ///< from the last one at or before the next left reading on
  std::optional<Stamp> newest_left_;  ///< of all, those that were paired too
};

}  // namespace bearing_calibration::core
