#pragma once

#include "bearing_calibration/calibration/config.h"

namespace bearing_calibration::core {

/// shippedCalibration() for the robots of tests and tools: without errors, and with a noise that is
/// known.
CalibratorConfig defaultCalibration(const DriveGeometry& drive, const WheelNoise& noise);

}  // namespace bearing_calibration::core
