#include "tools/study/default_calibration.h"

#include "bearing_calibration/calibration/shipped_calibration.h"
#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

CalibratorConfig defaultCalibration(const DriveGeometry& drive, const WheelNoise& noise) {
  CalibratorConfig config = shippedCalibration(drive);
  config.wheel_noise = noise;
  config.bearings.min_probability = 0.0;
  config.initializer = {};
  config.converged.yaw_stddev_rad = radiansFromDegrees(0.5);
  return config;
}

}  // namespace bearing_calibration::core
