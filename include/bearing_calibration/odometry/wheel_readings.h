#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

enum class WheelSide : std::uint8_t { kLeft, kRight };

/// The counter of one wheel: cumulative, wrapping at its width, at times reset by its driver.
struct WheelCount {
  Stamp stamp;
  std::int64_t ticks = 0;
};

/// The counters of both wheels at one moment.
/// (Not WheelTicks: that is the ROS message, which the message generator puts in this namespace.)
struct WheelCounts {
  Stamp stamp;
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
};

/// Positions of the two wheel joints: cumulative, or wrapping at one turn.
struct WheelAngles {
  Stamp stamp;
  double left_rad = 0.0;
  double right_rad = 0.0;
};

/// The base's pose as its driver has integrated it from the wheels, from any start on; a pose reset
/// by the driver at times.
struct OdometryPose {
  Stamp stamp;
  Pose2 start_from_base;
  double quaternion_norm = 1.0;  ///< of the orientation as it was sent
  double forward_mps = 0.0;      ///< the twist that was sent with it, only compared with the pose
  double turn_radps = 0.0;
  std::string frames;  ///< "PARENT, CHILD" as they were sent
};

/// How far each wheel has rolled since the first reading; what all kinds of reading become.
struct WheelTravel {
  Stamp stamp;
  double left_m = 0.0;
  double right_m = 0.0;
  double unseen_variance_m2 = 0.0;  ///< of each, for motion that breaks in the readings have hidden
};

/// Difference of two counts of a counter of `bits` (8, 16, 32 or 64) that wraps, the shorter way
/// round: in [-2^(bits-1), 2^(bits-1)).
std::int64_t wrappedTickDifference(std::int64_t from_ticks, std::int64_t to_ticks, int bits);

/// Whether a counter of `bits` can show this count, sent as signed or as unsigned.
bool fitsCounter(std::int64_t ticks, int bits);

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
  struct Stream {
    std::deque<WheelCount> waiting;
    std::optional<Stamp> newest;  ///< of all, those that no longer wait too
  };
  InputOutcome check(const WheelCount& reading, const std::optional<Stamp>& newest) const;
  void pairWhatIsCovered(PairingOutcome* outcome);

  int counter_bits_;
  double max_apart_s_;
  Stream left_;   ///< that wait for a right reading
  Stream right_;  ///< from the last one at or before the next left reading on
};

}  // namespace bearing_calibration::core
