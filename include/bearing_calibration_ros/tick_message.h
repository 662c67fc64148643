#pragma once

#include <ros/time.h>
#include <topic_tools/shape_shifter.h>

#include <string>

#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Whether a message of this definition is the count of one wheel: an integer `data`, first of its
/// fields or after a Header. So are std_msgs' Int16, Int32 and so on, and Duckietown's
/// WheelEncoderStamped.
bool isWheelCount(const std::string& message_definition);

/// The count of one wheel, with the stamp of its header, or of its receipt where it has none.
/// @throws std::invalid_argument that names the type, for a message that is no such count.
core::WheelCount countFromMessage(const topic_tools::ShapeShifter& message,
                                  const ros::Time& received);

}  // namespace bearing_calibration_ros
