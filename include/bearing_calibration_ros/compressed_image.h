#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <string>

namespace bearing_calibration_ros {

/// The image in a compressed one, with its header: a jpeg or png by the bytes themselves, of 8 or
/// 16 bits, a mosaic where `format` names one. Null where the bytes are no such image.
sensor_msgs::ImagePtr decoded(const sensor_msgs::CompressedImage& compressed);

/// What to say of one that is null.
std::string describeUndecoded(const sensor_msgs::CompressedImage& compressed);

}  // namespace bearing_calibration_ros
