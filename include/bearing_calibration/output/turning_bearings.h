#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core {

/// A number with its standard deviation.
struct MeasuredNumber {
  double value = 0.0;
  double stddev = 0.0;
};

/// Bearings of a robot that turns on the spot, where a light seems to turn as the wheels say, the
/// other way round, but for a Fourier series: a sensor off the axis, or a mirror that leans.
struct TurningBearings {
  int bearings = 0;
  double turn_rad = 0.0;       ///< in all, either way
  double stddev_rad = 0.0;     ///< as they scatter about that
  MeasuredNumber late_s;       ///< stamps against the wheels'
  MeasuredNumber more_turn;    ///< true turn over what the wheels say, less 1
  bool tells_latency = false;  ///< the rate of turn changes enough
};

/// None without a whole turn.
/// @param observations  of one light, as stated
std::optional<TurningBearings> checkTurning(const std::vector<Observation>& observations);

}  // namespace bearing_calibration::core
