#pragma once

#include <bearing_calibration/FindMirror.h>

#include <opencv2/core/mat.hpp>
#include <string>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// The answer to ~find_mirror for a grey image of 8 or 16 bits.
msg::FindMirrorResponse findMirror(const cv::Mat& image, const core::DetectorConfig& config);

/// The answer when there is nothing to look at, or nothing was found.
msg::FindMirrorResponse noMirror(const std::string& why);

}  // namespace bearing_calibration_ros
