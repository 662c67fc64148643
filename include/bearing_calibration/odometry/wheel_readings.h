#pragma once

#include <cstdint>

#include "bearing_calibration/common/stamp.h"

namespace bearing_calibration {

/// Raw encoder counters: cumulative, wrapping at the counter's width, at times reset by a driver.
struct WheelTicks {
  Stamp stamp;
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
};

/// Positions of the two wheel joints: cumulative and unbounded.
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
};

}  // namespace bearing_calibration
