#pragma once

#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <tf2_msgs/TFMessage.h>

#include <optional>
#include <string>

#include "bearing_calibration/optics/camera.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/refusal.h"
#include "bearing_calibration_ros/sensor_places.h"

namespace bearing_calibration_ros {

/// Why no rays can be made of it: not calibrated, or of a lens that is not known.
std::optional<Refusal> refusalOf(const sensor_msgs::CameraInfo& info);

/// The camera of the images as they are delivered, a region of the imager, binned (REP 104): that
/// of a level camera that looks along the sensor's x axis.
/// @param info  that refusalOf() has nothing against
core::Camera cameraFromMessage(const sensor_msgs::CameraInfo& info);

/// The rays of a camera without a mirror: what its camera_info and /tf_static say.
class CameraRays {
 public:
  /// @param topic  of the camera_info, for people
  CameraRays(const std::string& sensor_frame, const std::string& topic)
      : places_(sensor_frame), topic_(topic) {}

  void add(const sensor_msgs::CameraInfoConstPtr& info) { info_ = info; }
  void add(const tf2_msgs::TFMessage& static_transforms) { places_.add(static_transforms); }

  /// Why the rays of an image are not known.
  std::optional<Refusal> refusalOf(const sensor_msgs::Image& image) const;
  /// @param image  that refusalOf() has nothing against
  core::Camera of(const sensor_msgs::Image& image) const;

 private:
  SensorPlaces places_;
  std::string topic_;
  sensor_msgs::CameraInfoConstPtr info_;  ///< the newest
};

}  // namespace bearing_calibration_ros
