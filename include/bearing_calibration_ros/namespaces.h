#pragma once

namespace bearing_calibration::core {}

namespace bearing_calibration_ros {

namespace core = bearing_calibration::core;  ///< all that knows no ROS
namespace msg = bearing_calibration;         ///< generated messages, services and actions

}  // namespace bearing_calibration_ros
