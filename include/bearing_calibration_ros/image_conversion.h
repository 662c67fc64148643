#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Header.h>

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/refusal.h"

namespace bearing_calibration_ros {

/// Pixels of that encoding as a message, which has a copy of them.
sensor_msgs::ImagePtr imageMessage(const std_msgs::Header& header, const std::string& encoding,
                                   const cv::Mat& pixels);

/// Compares the message with itself (data against step and height, step against width and
/// encoding) and with the sensor that is configured. Nothing when it may be converted.
std::optional<Refusal> refusalOf(const sensor_msgs::Image& image, const core::ImageSensor& sensor);

/// The image in a compressed one, with its header: a jpeg or png by the bytes themselves, of 8 or
/// 16 bits, a mosaic where `format` names one. Null where the bytes are no such image.
sensor_msgs::ImagePtr decoded(const sensor_msgs::CompressedImage& compressed);
/// What to say of one that is null.
std::string describeUndecoded(const sensor_msgs::CompressedImage& compressed);

/// Whether images of this encoding have colours.
bool hasColours(const std::string& encoding);

/// Image messages as grey images of 8 or 16 bits: mono8, mono16, 8UC1, 16UC1 (shared, not copied),
/// bgr8, rgb8, bgra8, rgba8, bayer_*8, bayer_*16, yuv422 and yuv422_yuy2 (converted into a buffer
/// that is kept).
class GreyConverter {
 public:
  /// @param image refusalOf() it is nothing.
  /// @return valid until the next call.
  const cv::Mat& convert(const sensor_msgs::ImageConstPtr& image);

  /// The same as CV_8UC3, blue first; of 16 bits so that `full_levels` becomes 255.
  /// @throws std::invalid_argument for an image without colours.
  const cv::Mat& convertToColour(const sensor_msgs::ImageConstPtr& image, double full_levels);

 private:
  const cv::Mat& take(const sensor_msgs::ImageConstPtr& image);

  sensor_msgs::ImageConstPtr shared_;  ///< whose pixels `pixels_` are
  cv::Mat pixels_;
  cv::Mat swapped_;
  cv::Mat converted_;
  cv::Mat colour_;
  cv::Mat scaled_;
};

}  // namespace bearing_calibration_ros
