#pragma once

#include "bearing_calibration/calibration/config.h"

namespace bearing_calibration::core {

/// The values of config/calibration.yaml, with a start from nothing, for the robots of tests and
/// tools.
CalibratorConfig defaultCalibration(const DriveGeometry& drive, const WheelNoise& noise);

}  // namespace bearing_calibration::core
