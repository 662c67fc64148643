#include "tools/study/simple_blob.h"

#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

cv::SimpleBlobDetector::Params simpleBlobParams(const DetectorConfig& config) {
  const Range area = ExpectedSpot(config).area_px();
  cv::SimpleBlobDetector::Params params;
  params.blobColor = 255;
  params.filterByArea = true;
  params.minArea = static_cast<float>(0.5 * area.low);
  params.maxArea = static_cast<float>(2.0 * area.high);
  params.filterByInertia = true;
  params.minInertiaRatio = 0.15F;  // of an ellipse of 11 x 20 px: 0.3
  params.maxInertiaRatio = 0.6F;
  params.filterByConvexity = true;
  params.minConvexity = 0.9F;
  params.filterByCircularity = false;
  return params;
}

}  // namespace bearing_calibration::core
