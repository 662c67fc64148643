#pragma once

#include <opencv2/core/mat.hpp>

#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration::core {

/// The image in colour with what the detector saw: green, an accepted light with its azimuth and
/// deviation; red, a rejected spot with the reason; blue, the mask's circles and the horizon.
/// @param image as given to the detector
cv::Mat annotate(const cv::Mat& image, const DetectionResult& result, const DetectorConfig& config);

/// The image in colour with the mirror's rim and its centre in green, and the places of its edge
/// in red.
/// @param image CV_8UC1 or CV_16UC1 in its full range
cv::Mat annotateRim(const cv::Mat& image, const MirrorRim& rim);

}  // namespace bearing_calibration::core
