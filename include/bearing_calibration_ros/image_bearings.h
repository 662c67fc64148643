#pragma once

#include <sensor_msgs/Image.h>

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/vision/blink_identifier.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Image messages in, bearings out: what the detection nodelet and the offline tools share.
class ImageBearings {
 public:
  explicit ImageBearings(const DetectionNodeConfig& config);

  /// Looks with another detector from the next image on; what is known of blinking stays.
  void setDetector(const core::DetectorConfig& detector);

  /// Moment of the image's middle row, for which a prediction is of use.
  core::Stamp middleOf(const sensor_msgs::Image& image) const;

  /// @param image  that refusalOf() has nothing against
  /// @param prediction  of the bearing at about that moment
  core::BearingSet detect(const sensor_msgs::ImageConstPtr& image,
                          const std::optional<core::BearingPrediction>& prediction);

  /// What the last image showed, and that image in grey.
  const core::DetectionResult& result() const { return *result_; }
  const cv::Mat& grey() const { return *grey_; }

 private:
  DetectionNodeConfig config_;
  core::LightDetector detector_;
  std::optional<core::BlinkIdentifier> blink_;  ///< none unless blink/use is set
  GreyConverter converter_;
  const core::DetectionResult* result_ = nullptr;
  const cv::Mat* grey_ = nullptr;
  std::optional<core::SeenRadius> seen_;  ///< by the last light that was expected
  std::uint64_t images_ = 0;
};

}  // namespace bearing_calibration_ros
