#pragma once

#include <string>
#include <vector>

namespace bearing_calibration::core {

/// When the calibration may call itself converged. Parameter group `converged`.
struct ConvergenceConfig {
  double position_stddev_m = 0.0;  ///< x and y each
  double yaw_stddev_rad = 0.0;

  std::vector<std::string> validate() const;
};

}  // namespace bearing_calibration::core
