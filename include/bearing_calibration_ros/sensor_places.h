#pragma once

#include <std_msgs/Header.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/refusal.h"

namespace bearing_calibration_ros {

/// tf2 knows no slash in front of a frame; drivers of the time before it set one.
std::string withoutSlash(const std::string& frame);
bool areOneFrame(const std::string& one, const std::string& other);

/// Of a frame that is to be sent: with a slash in front it could not be found.
void declareFrame(const std::string& name, std::string& frame, core::Parameters& params);

/// A sensor's frame must have z up; the name of an optical one says that it has not.
void requireLevel(core::Parameters& params, const std::string& sensor_frame);

/// Where the frames of messages are in the sensor's frame, by /tf_static.
class SensorPlaces {
 public:
  explicit SensorPlaces(const std::string& sensor_frame)
      : sensor_frame_(withoutSlash(sensor_frame)) {}

  void add(const tf2_msgs::TFMessage& static_transforms);

  const std::string& sensorFrame() const { return sensor_frame_; }

  /// Why a message has no moment or no place.
  std::optional<Refusal> refusalOf(const std_msgs::Header& header) const;
  /// @param frame  of a header that refusalOf() has nothing against
  Eigen::Isometry3d sensorFrom(const std::string& frame) const;

 private:
  std::string sensor_frame_;
  tf2::BufferCore static_transforms_;
};

}  // namespace bearing_calibration_ros
