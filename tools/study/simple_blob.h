#pragma once

#include <opencv2/features2d.hpp>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

/// OpenCV's blob detector, told the spot's area, that it is bright, and its slimness: what one
/// would use instead.
cv::SimpleBlobDetector::Params simpleBlobParams(const DetectorConfig& config);

}  // namespace bearing_calibration::core
