#pragma once

#include <bearing_calibration/FindMirror.h>
#include <sensor_msgs/CameraInfo.h>

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration_ros/namespaces.h"

/// Whether camera and mirror are those of the configuration.
namespace bearing_calibration_ros {

/// The images that a camera_info is about, as they are delivered. Its own numbers are those of the
/// whole imager, of which a region is cut out and then binned (REP 104).
struct DeliveredImage {
  std::uint32_t width_px = 0;  ///< 0: not said, as by the driver of a camera without calibration
  std::uint32_t height_px = 0;
  double focal_length_px = 0.0;  ///< 0: not said

  bool isSaid() const { return width_px > 0 && height_px > 0; }
  bool isOf(const core::ImageSensor& sensor) const;
};

DeliveredImage deliveredImage(const sensor_msgs::CameraInfo& info);

/// What of it the configuration contradicts, in a sentence; empty when nothing does.
std::string contradiction(const DeliveredImage& image, const core::DetectorConfig& detector);

/// The answer to ~find_mirror for a grey image of 8 or 16 bits.
msg::FindMirrorResponse findMirror(const cv::Mat& image, const core::DetectorConfig& config);
/// The answer when there is nothing to look at, or nothing was found.
msg::FindMirrorResponse noMirror(const std::string& why);

}  // namespace bearing_calibration_ros
