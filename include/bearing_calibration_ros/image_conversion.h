#pragma once

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration_ros {

/// Why an image message cannot be used.
struct ImageRefusal {
  std::string kind;  ///< the same word for the same fault: counted by it
  std::string text;  ///< with the values
};

/// Compares the message with itself (data against step and height, step against width and
/// encoding) and with the sensor that is configured. Nothing when it may be converted.
std::optional<ImageRefusal> refusalOf(const sensor_msgs::Image& image,
                                      const bearing_calibration::ImageSensor& sensor);

/// Whether images of this encoding have colours.
bool hasColours(const std::string& encoding);

/// Image messages as grey images of 8 or 16 bits: mono8, mono16, 8UC1, 16UC1 (shared, not copied),
/// bgr8, rgb8, bgra8, rgba8 and bayer_*8 (converted into a buffer that is kept).
class GreyConverter {
 public:
  /// @param image refusalOf() it is nothing.
  /// @return valid until the next call.
  const cv::Mat& convert(const sensor_msgs::ImageConstPtr& image);

  /// The same as CV_8UC3, blue first. @throws std::invalid_argument for an image without colours.
  const cv::Mat& convertToColour(const sensor_msgs::ImageConstPtr& image);

 private:
  cv_bridge::CvImageConstPtr shared_;
  cv::Mat converted_;
  cv::Mat colour_;
};

}  // namespace bearing_calibration_ros
