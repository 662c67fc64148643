#pragma once

#include <sensor_msgs/Image.h>

#include <cstdint>
#include <optional>

#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration_ros/image_bearings.h"

namespace bearing_calibration_ros {

/// The way of image messages through the detection node: checked, converted, searched, followed
/// from image to image, learnt from, judged, drawn.
class DetectionFuzzer {
 public:
  /// @param kind  what differs from the shipped configuration, see rigFor()
  explicit DetectionFuzzer(std::uint8_t kind = 0) : kind_(kind) {}

  /// One image. The first that can be one says of which size they all are.
  /// @return whether it was searched
  /// @throws std::logic_error when what comes out means nothing: an azimuth that is no angle, a
  ///   variance that is not positive, a probability outside of [0, 1]
  bool see(const sensor_msgs::Image& image,
           const std::optional<core::BearingPrediction>& prediction = std::nullopt);

  /// What there is to say of the images since the last call.
  void takeAdvice();
  /// Looks for the mirror's rim in the last image.
  void findMirrorInIt() const;

 private:
  std::uint8_t kind_;
  DetectionNodeConfig config_;
  std::optional<ImageBearings> bearings_;  ///< from the first image on
  core::AdviceTally advice_;
};

}  // namespace bearing_calibration_ros
