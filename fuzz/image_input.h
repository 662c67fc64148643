#pragma once

#include <sensor_msgs/Image.h>

#include "fuzz/byte_reader.h"

namespace bearing_calibration_ros {

/// An image message as a broken or a sound driver may send it: a size and an encoding out of lists
/// (with unknown ones), now and then a wrong step, a truncated body or a zero stamp, and in it
/// black, white, noise, or ellipses drawn one by one, so that the fuzzer finds its way to spots.
sensor_msgs::Image imageFrom(bearing_calibration::fuzz::ByteReader* bytes);

}  // namespace bearing_calibration_ros
