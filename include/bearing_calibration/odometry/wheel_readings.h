#pragma once

#include <cstdint>

#include "bearing_calibration/common/stamp.h"

namespace bearing_calibration::core {

/// Raw encoder counters: cumulative, wrapping at the counter's width, at times reset by a driver.
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

/// How far each wheel has rolled since the first reading; what both kinds of reading become.
struct WheelTravel {
  Stamp stamp;
  double left_m = 0.0;
  double right_m = 0.0;
  double unseen_variance_m2 = 0.0;  ///< of each, for motion that breaks in the readings have hidden
};

}  // namespace bearing_calibration::core
