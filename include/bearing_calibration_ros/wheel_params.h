#pragma once

#include <cstdint>

#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// What the wheels' readings are.
enum class WheelSource : std::uint8_t {
  kTicks,          ///< bearing_calibration/WheelTicks
  kJointStates,    ///< sensor_msgs/JointState
  kSeparateTicks,  ///< the count of each wheel on a topic of its own (see tick_message.h)
};

/// Parameter group `wheels` of config/calibration.yaml: what the calibration and the drive both
/// know of the wheels, from one place.
struct WheelParams {
  WheelSource source = WheelSource::kTicks;
  WheelJoints joints;
  core::DriveGeometry drive;
  core::WheelNoise noise;
  double max_apart_s = 0.0;  ///< see core::WheelPairing
  double history_s = 0.0;    ///< travel is remembered so long

  std::vector<std::string> validate() const;
};

WheelParams readWheels(ParamReader& params);

}  // namespace bearing_calibration_ros
