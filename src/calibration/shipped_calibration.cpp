#include "bearing_calibration/calibration/shipped_calibration.h"

#include "bearing_calibration/filter/error_blocks.h"

namespace bearing_calibration::core {

CalibratorConfig shippedCalibration(const DriveGeometry& drive) {
  CalibratorConfig config;
  config.drive = drive;
  config.wheel_noise = {1e-6, 0.0};
  config.wheel_times = {0.2, 10.0};
  config.bearings.min_stddev_rad = 1e-4;
  config.bearings.max_stddev_rad = 0.35;
  config.bearings.max_future_s = 0.2;
  config.bearings.reorder_window_s = 0.2;
  config.bearings.max_waiting = 100;
  config.bearings.min_probability = 0.1;
  ErrorPriors& errors = config.initializer.batch.errors;
  errors.setBlock(TimeOffset::kName, 0.1);
  errors.setBlock(WheelScales::kName, 0.03);
  errors.setBlock(WheelSeparation::kName, 0.01);
  errors.setLightHeight(0.0, 0.5);
  config.initializer.noise = {1.0, 2.0};
  config.filter.gate_probability = 0.999;
  config.converged.position_stddev_m = 0.01;
  config.converged.yaw_stddev_rad = 0.0087;
  return config;
}

}  // namespace bearing_calibration::core
