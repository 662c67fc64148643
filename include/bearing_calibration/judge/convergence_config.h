#pragma once

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// When the calibration may call itself converged. Parameter group `converged`.
struct ConvergenceConfig {
  double position_stddev_m = 0.0;  ///< x and y each
  double yaw_stddev_rad = 0.0;

  void declare(Parameters& params);
};

}  // namespace bearing_calibration::core
