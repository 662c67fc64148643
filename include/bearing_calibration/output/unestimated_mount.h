#pragma once

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// The part of the sensor's pose in the base frame that bearings of one light in the plane say
/// nothing about. It is configured and passed on, never estimated. Parameter group `mount`.
struct UnestimatedMount {
  double z_m = 0.0;
  double z_stddev_m = 0.0;  ///< > 0, like the other two: nothing is known exactly
  double roll_rad = 0.0;
  double roll_stddev_rad = 0.0;
  double pitch_rad = 0.0;
  double pitch_stddev_rad = 0.0;

  void declare(Parameters& params);
};

}  // namespace bearing_calibration::core
