#pragma once

#include <bearing_calibration/FindMirror.h>

#include <opencv2/core/mat.hpp>
#include <string>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration_ros {

/// The answer to ~find_mirror for a grey image of 8 or 16 bits.
bearing_calibration::FindMirrorResponse findMirror(
    const cv::Mat& image, const bearing_calibration::DetectorConfig& config);

/// The answer when there is nothing to look at, or nothing was found.
bearing_calibration::FindMirrorResponse noMirror(const std::string& why);

}  // namespace bearing_calibration_ros
