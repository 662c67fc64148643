#pragma once

#include <cstdint>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// What the wheels' readings are.
enum class WheelSource : std::uint8_t {
  kTicks,          ///< bearing_calibration/WheelTicks
  kJointStates,    ///< sensor_msgs/JointState
  kSeparateTicks,  ///< the count of each wheel on a topic of its own (see tick_message.h)
};

/// The wheels' messages, for the calibration and the drive. Of the parameter group `wheels` of
/// config/calibration.yaml.
struct WheelInput {
  WheelSource source = WheelSource::kTicks;
  WheelJoints joints;

  void declare(core::Parameters& params);
};

}  // namespace bearing_calibration_ros
