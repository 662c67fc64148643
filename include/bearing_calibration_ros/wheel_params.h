#pragma once

#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// Parameter group `wheels` of config/calibration.yaml: what the calibration and the drive both
/// know of the wheels, from one place.
struct WheelParams {
  bool from_joint_states = false;
  WheelJoints joints;
  bearing_calibration::DriveGeometry drive;
  bearing_calibration::WheelNoise noise;
  double history_s = 0.0;  ///< travel is remembered so long

  std::vector<std::string> validate() const;
};

WheelParams readWheels(ParamReader& params);

}  // namespace bearing_calibration_ros
