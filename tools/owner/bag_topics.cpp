#include "tools/owner/bag_topics.h"

#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/WheelTicks.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <image_transport/camera_common.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration::core {
namespace {

using bearing_calibration_ros::WheelSource;

/// Types by topic.
using Contents = std::map<std::string, std::string>;

std::string withoutSlash(const std::string& topic) {
  return topic.empty() || topic.front() != '/' ? topic : topic.substr(1);
}

/// Whether it has the name of one of these types, but another definition: rosbag would leave its
/// messages out without a word.
template <typename... Messages>
bool isOfAnotherVersion(const rosbag::ConnectionInfo& connection) {
  return ((connection.datatype == ros::message_traits::datatype<Messages>() &&
           connection.md5sum != ros::message_traits::md5sum<Messages>()) ||
          ...);
}

std::string listOf(const Contents& contents) {
  std::string list;
  for (const auto& [topic, type] : contents) list += "\n  " + topic + " (" + type + ")";
  return contents.empty() ? " nothing" : list;
}

std::vector<std::string> topicsOfType(const Contents& contents, const std::string& type) {
  std::vector<std::string> topics;
  for (const auto& topic_and_type : contents) {
    if (topic_and_type.second == type) topics.push_back(topic_and_type.first);
  }
  return topics;
}

/// The topic of that name, or else the only one of the type.
template <typename Message>
std::string findTopic(const Contents& contents, const std::string& wanted,
                      const std::string& option) {
  const std::string type = ros::message_traits::datatype<Message>();
  if (!wanted.empty()) {
    for (const auto& [topic, topics_type] : contents) {
      if (withoutSlash(topic) == withoutSlash(wanted) && topics_type == type) return topic;
    }
    throw std::runtime_error("no topic " + wanted + " of type " + type + "; the bag holds" +
                             listOf(contents));
  }
  const std::vector<std::string> topics = topicsOfType(contents, type);
  if (topics.size() == 1) return topics.front();
  throw std::runtime_error(
      (topics.empty() ? "no topic of type " + type
                      : "several topics of type " + type + ": choose one by --" + option) +
      "; the bag holds" + listOf(contents));
}

/// The same of images; where there are none as they are, of compressed ones, which a camera sends
/// on the topic's name with "/compressed" behind it.
std::string findImages(const Contents& contents, const std::string& wanted) {
  const std::string raw = ros::message_traits::datatype<sensor_msgs::Image>();
  const std::string compressed = ros::message_traits::datatype<sensor_msgs::CompressedImage>();
  if (wanted.empty()) {
    if (!topicsOfType(contents, raw).empty()) {
      return findTopic<sensor_msgs::Image>(contents, wanted, "image-topic");
    }
    if (!topicsOfType(contents, compressed).empty()) {
      return findTopic<sensor_msgs::CompressedImage>(contents, wanted, "image-topic");
    }
    const std::string bearings = ros::message_traits::datatype<LightBearings>();
    throw std::runtime_error("no bearings (" + bearings + ") and no images (" + raw + " or " +
                             compressed + "); the bag holds" + listOf(contents));
  }
  for (const std::string& name : {wanted, wanted + "/compressed"}) {
    for (const auto& [topic, type] : contents) {
      if (withoutSlash(topic) == withoutSlash(name) && (type == raw || type == compressed)) {
        return topic;
      }
    }
  }
  throw std::runtime_error("no topic " + wanted + " of type " + raw + " or " + compressed +
                           "; the bag holds" + listOf(contents));
}

/// The topic of that name, or else of the default's, with the count of one wheel.
std::string findWheel(const Contents& contents, const std::set<std::string>& wheel_counts,
                      const std::string& wanted, const std::string& default_name) {
  const std::string name = withoutSlash(wanted.empty() ? default_name : wanted);
  for (const std::string& topic : wheel_counts) {
    if (withoutSlash(topic) == name) return topic;
  }
  throw std::runtime_error("no topic " + name +
                           " with the count of one wheel, such as std_msgs/Int32: choose one by "
                           "--wheels-topic LEFT --right-wheel-topic RIGHT; the bag holds" +
                           listOf(contents));
}

/// The topic of that name and type, with or without a slash in front; empty without one.
template <typename Message>
std::string findBeside(const Contents& contents, const std::string& name) {
  for (const std::string& topic :
       topicsOfType(contents, ros::message_traits::datatype<Message>())) {
    if (withoutSlash(topic) == withoutSlash(name)) return topic;
  }
  return {};
}

/// Where a driver sends the camera_info of its images, raw or compressed.
std::string cameraInfoTopic(const std::string& images) {
  const std::string suffix = "/compressed";
  const std::size_t end = images.size() - std::min(images.size(), suffix.size());
  return image_transport::getCameraInfoTopic(images.substr(end) == suffix ? images.substr(0, end)
                                                                          : images);
}

/// What a CalibrationDriveNodelet of whatever name has published; empty without one.
std::string findPlan(const Contents& contents) {
  const std::string name = "expected_base_from_camera";
  const std::string type =
      ros::message_traits::datatype<geometry_msgs::PoseWithCovarianceStamped>();
  for (const std::string& topic : topicsOfType(contents, type)) {
    if (topic.substr(topic.rfind('/') + 1) == name) return topic;
  }
  return {};
}

}  // namespace

std::vector<std::string> BagTopics::names() const {
  std::vector<std::string> names = {wheels};
  for (const std::string& topic : {right_wheel, plan, camera_info, static_transforms}) {
    if (!topic.empty()) names.push_back(topic);
  }
  names.push_back(observations());
  return names;
}

BagTopics findTopics(rosbag::View& whole_bag, const BagTopics& wanted, WheelSource source) {
  Contents contents;
  std::set<std::string> wheel_counts;
  for (const rosbag::ConnectionInfo* connection : whole_bag.getConnections()) {
    const bool is_foreign = isOfAnotherVersion<WheelTicks, LightBearings>(*connection);
    contents[connection->topic] =
        connection->datatype + (is_foreign ? " of another version of this package" : "");
    if (bearing_calibration_ros::isWheelCount(connection->msg_def)) {
      wheel_counts.insert(connection->topic);
    }
  }
  BagTopics found;
  switch (source) {
    case WheelSource::kTicks:
      found.wheels = findTopic<WheelTicks>(contents, wanted.wheels, "wheels-topic");
      break;
    case WheelSource::kJointStates:
      found.wheels = findTopic<sensor_msgs::JointState>(contents, wanted.wheels, "wheels-topic");
      break;
    case WheelSource::kOdometry:
      found.wheels = findTopic<nav_msgs::Odometry>(contents, wanted.wheels, "wheels-topic");
      break;
    case WheelSource::kSeparateTicks:
      found.wheels = findWheel(contents, wheel_counts, wanted.wheels, "left_ticks");
      found.right_wheel = findWheel(contents, wheel_counts, wanted.right_wheel, "right_ticks");
  }
  const bool has_bearings =
      !topicsOfType(contents, ros::message_traits::datatype<LightBearings>()).empty();
  if (wanted.images.empty() && (has_bearings || !wanted.bearings.empty())) {
    found.bearings = findTopic<LightBearings>(contents, wanted.bearings, "bearings-topic");
  } else {
    found.images = findImages(contents, wanted.images);
    found.camera_info =
        findBeside<sensor_msgs::CameraInfo>(contents, cameraInfoTopic(found.images));
    found.static_transforms = findBeside<tf2_msgs::TFMessage>(contents, "tf_static");
  }
  found.plan = findPlan(contents);
  return found;
}

}  // namespace bearing_calibration::core
