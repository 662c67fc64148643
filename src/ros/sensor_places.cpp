#include "bearing_calibration_ros/sensor_places.h"

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {

std::string withoutSlash(const std::string& frame) {
  return frame.substr(frame.rfind('/', 0) == 0 ? 1 : 0);
}

bool areOneFrame(const std::string& one, const std::string& other) {
  return withoutSlash(one) == withoutSlash(other);
}

void declareFrame(const std::string& name, std::string& frame, core::Parameters& params) {
  params.read(name, frame);
  params.that(!frame.empty() && frame.front() != '/' && frame.find(' ') == std::string::npos,
              name + " must be a frame's name without slash in front and without spaces, but is '" +
                  frame + "'");
}

void requireLevel(core::Parameters& params, const std::string& sensor_frame) {
  params.that(sensor_frame.find("optical") == std::string::npos,
              "frames/sensor must have z up, but '" + sensor_frame +
                  "' is an optical frame by its name, with z ahead: give the camera's other one");
}

void SensorPlaces::add(const tf2_msgs::TFMessage& static_transforms) {
  constexpr bool kStatic = true;
  for (const geometry_msgs::TransformStamped& transform : static_transforms.transforms) {
    static_transforms_.setTransform(transform, "/tf_static", kStatic);
  }
}

std::optional<Refusal> SensorPlaces::refusalOf(const std_msgs::Header& header) const {
  const std::string frame = withoutSlash(header.frame_id);
  if (header.stamp.isZero()) return Refusal{"stamp is zero", "its driver must set it"};
  if (frame.empty()) return Refusal{"frame_id is empty", "its driver must set it"};
  if (frame == sensor_frame_) return std::nullopt;
  if (static_transforms_.canTransform(sensor_frame_, frame, ros::Time())) {
    if (sensorFrom(frame).matrix().allFinite()) return std::nullopt;
    return Refusal{"static transform not finite",
                   "what /tf_static says between its frame '" + frame + "' and frames/sensor '" +
                       sensor_frame_ + "' has a number that is not finite"};
  }
  return Refusal{"no static transform",
                 "nothing on /tf_static connects its frame '" + frame + "' with frames/sensor '" +
                     sensor_frame_ +
                     "'. Publish it, as by rosrun tf2_ros static_transform_publisher X Y Z YAW "
                     "PITCH ROLL " +
                     sensor_frame_ + " " + frame};
}

Eigen::Isometry3d SensorPlaces::sensorFrom(const std::string& frame) const {
  if (withoutSlash(frame) == sensor_frame_) return Eigen::Isometry3d::Identity();
  return isometryFromMessage(
      static_transforms_.lookupTransform(sensor_frame_, withoutSlash(frame), ros::Time())
          .transform);
}

}  // namespace bearing_calibration_ros
