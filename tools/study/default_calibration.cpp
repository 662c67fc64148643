#include "tools/study/default_calibration.h"

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

CalibratorConfig defaultCalibration(const DriveGeometry& drive, const WheelNoise& noise) {
  CalibratorConfig config;
  config.drive = drive;
  config.wheel_noise = noise;
  config.wheel_times = {0.2, 10.0};
  config.bearings.min_stddev_rad = 1e-4;
  config.bearings.max_stddev_rad = 0.35;
  config.bearings.max_future_s = 0.2;
  config.bearings.max_waiting = 100;
  config.filter.gate_probability = 0.999;
  config.converged.position_stddev_m = 0.01;
  config.converged.yaw_stddev_rad = radiansFromDegrees(0.5);
  return config;
}

}  // namespace bearing_calibration::core
