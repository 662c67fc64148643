#pragma once

#include "bearing_calibration/calibration/config.h"

namespace bearing_calibration::core {

/// What config/calibration.yaml says, for a program without parameter files (a test compares them).
/// @param drive  of the robot: none of its numbers has a default
CalibratorConfig shippedCalibration(const DriveGeometry& drive);

}  // namespace bearing_calibration::core
