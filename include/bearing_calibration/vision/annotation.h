#pragma once

#include <opencv2/core/mat.hpp>

#include "bearing_calibration/vision/light_detector.h"

namespace bearing_calibration {

/// The image in colour with what the detector saw: green, an accepted light with its azimuth and
/// deviation; red, a rejected spot with the reason; blue, the mask's circles and the horizon.
/// @param image as given to the detector
cv::Mat annotate(const cv::Mat& image, const DetectionResult& result, const DetectorConfig& config);

}  // namespace bearing_calibration
