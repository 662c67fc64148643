#pragma once

#include <sensor_msgs/Image.h>

#include <map>
#include <memory>
#include <utility>

#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration_ros/image_conversion.h"

namespace bearing_calibration_ros {

/// The way of an image message through the detection node: checked, converted, searched, published.
class DetectionFuzzer {
 public:
  /// An image that is refused, or searched with and without a predicted region.
  /// @return whether it was searched
  /// @throws std::logic_error when a result means nothing: an azimuth that is no angle, a variance
  ///   that is not positive, a probability outside of [0, 1]
  bool run(const sensor_msgs::Image& image);

 private:
  bearing_calibration::core::LightDetector& detectorFor(const sensor_msgs::Image& image);

  /// By width and height: some take long to make.
  std::map<std::pair<std::uint32_t, std::uint32_t>,
           std::unique_ptr<bearing_calibration::core::LightDetector>>
      detectors_;
  GreyConverter converter_;
};

}  // namespace bearing_calibration_ros
