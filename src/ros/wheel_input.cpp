#include "bearing_calibration_ros/wheel_input.h"

#include <ros/serialization.h>
#include <std_msgs/Header.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

std::optional<double> positionOf(const std::string& joint, const sensor_msgs::JointState& message) {
  const auto found = std::find(message.name.begin(), message.name.end(), joint);
  const auto index = static_cast<std::size_t>(found - message.name.begin());
  if (found == message.name.end() || index >= message.position.size()) return std::nullopt;
  return message.position[index];
}

/// What lies at the beginning of the message of one wheel.
struct CountLayout {
  bool has_header = false;
  bool is_signed = false;
  unsigned bits = 0;
};

std::optional<CountLayout> layoutOf(const std::string& definition) {
  CountLayout layout;
  std::istringstream lines(definition);
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find('#'));
    if (line.find('=') != std::string::npos) continue;  // a constant
    std::istringstream words(line);
    std::string type, name;
    if (!(words >> type >> name)) continue;
    const bool is_header = type == "Header" || type == "std_msgs/Header";
    if (is_header && !layout.has_header) {
      layout.has_header = true;
      continue;
    }
    if (name != "data") return std::nullopt;
    for (const unsigned bits : {8U, 16U, 32U, 64U}) {
      layout.bits = bits;
      layout.is_signed = type == "int" + std::to_string(bits);
      if (layout.is_signed || type == "uint" + std::to_string(bits)) return layout;
    }
    return std::nullopt;
  }
  return std::nullopt;
}

/// Of the type of a message. Its definition is read once: topics of wheels have a type or two.
const std::optional<CountLayout>& layoutOf(const topic_tools::ShapeShifter& message) {
  thread_local std::map<std::string, std::optional<CountLayout>> layouts;  // by definition
  const auto [known, is_new] = layouts.try_emplace(message.getMessageDefinition());
  if (is_new) known->second = layoutOf(known->first);
  return known->second;
}

/// An integer of a message, which has its low bytes first.
std::int64_t readInteger(const CountLayout& layout, ros::serialization::IStream* stream) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < layout.bits; shift += 8U) {
    std::uint8_t byte = 0;
    stream->next(byte);
    value |= static_cast<std::uint64_t>(byte) << shift;
  }
  const bool is_negative = layout.is_signed && (value >> (layout.bits - 1U)) != 0U;
  if (is_negative && layout.bits < 64U) value |= ~std::uint64_t{0} << layout.bits;
  return static_cast<std::int64_t>(value);
}

}  // namespace

void WheelInput::declare(core::Parameters& params) {
  params.choice("wheels/source", {"ticks", "joint_states", "separate_ticks", "odometry"}, source);
  params.read("wheels/left_joint", joints.left);
  params.read("wheels/right_joint", joints.right);
  params.that(
      joints.left != joints.right,
      "wheels/left_joint must not be wheels/right_joint, but both are '" + joints.left + "'");
  // Poses need no wheels but for a picture of them, angles no ticks but for what is less than a
  // jump.
  constexpr double kDrawnRadius_m = 0.05;
  constexpr double kFineTicks = 65536.0;
  const bool has_poses = source == WheelSource::kOdometry;
  if (has_poses) {
    params.standIn("wheels/left_radius", kDrawnRadius_m);
    params.standIn("wheels/right_radius", kDrawnRadius_m);
  }
  if (has_poses || source == WheelSource::kJointStates) {
    params.standIn("wheels/ticks_per_revolution", kFineTicks);
  }
}

core::WheelCounts countsFromMessage(const msg::WheelTicks& message) {
  return {stampFromRos(message.header.stamp), message.left, message.right};
}

std::optional<core::WheelAngles> anglesFromMessage(const sensor_msgs::JointState& message,
                                                   const WheelJoints& joints) {
  const std::optional<double> left = positionOf(joints.left, message);
  const std::optional<double> right = positionOf(joints.right, message);
  if (!left || !right) return std::nullopt;
  return core::WheelAngles{stampFromRos(message.header.stamp), *left, *right};
}

bool namesEither(const sensor_msgs::JointState& message, const WheelJoints& joints) {
  return std::any_of(message.name.begin(), message.name.end(), [&](const std::string& name) {
    return name == joints.left || name == joints.right;
  });
}

std::string describeMissing(const WheelJoints& joints, const sensor_msgs::JointState& message) {
  const std::string positions =
      message.position.size() == message.name.size()
          ? ""
          : " with " + std::to_string(message.position.size()) + " positions";
  return "joints '" + joints.left + "' and '" + joints.right +
         "' with a position each are wanted, but the message has (" +
         core::joined(message.name, ", ") + ")" + positions + ": message ignored";
}

core::OdometryPose odometryFromMessage(const nav_msgs::Odometry& message) {
  const geometry_msgs::Point& position = message.pose.pose.position;
  const geometry_msgs::Quaternion& q = message.pose.pose.orientation;
  const double yaw_rad =
      std::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z));
  const double norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  const geometry_msgs::Twist& twist = message.twist.twist;
  return {stampFromRos(message.header.stamp),
          {{position.x, position.y}, yaw_rad},
          norm,
          twist.linear.x,
          twist.angular.z,
          message.header.frame_id + ", " + message.child_frame_id};
}

bool isWheelCount(const std::string& message_definition) {
  return layoutOf(message_definition).has_value();
}

core::WheelCount countFromMessage(const topic_tools::ShapeShifter& message,
                                  const ros::Time& received) {
  const std::optional<CountLayout>& layout = layoutOf(message);
  if (!layout) {
    throw std::invalid_argument("a message of type " + message.getDataType() +
                                " is no wheel's count: it has no integer 'data' in the first "
                                "place or after its header");
  }
  std::vector<std::uint8_t> bytes(message.size());
  ros::serialization::OStream writer(bytes.data(), message.size());
  message.write(writer);
  ros::serialization::IStream reader(bytes.data(), message.size());
  std_msgs::Header header;
  header.stamp = received;
  try {
    if (layout->has_header) reader.next(header);
    return {stampFromRos(header.stamp), readInteger(*layout, &reader)};
  } catch (const ros::serialization::StreamOverrunException&) {
    throw std::invalid_argument("a message of type " + message.getDataType() +
                                " is cut short: it has " + std::to_string(message.size()) +
                                " bytes");
  }
}

std::vector<std::string> wheelTopics(WheelSource source) {
  static const std::vector<std::string> kTopics[] = {
      {"wheel_ticks"}, {"joint_states"}, {"left_ticks", "right_ticks"}, {"odom"}};
  return kTopics[static_cast<std::size_t>(source)];
}

std::vector<ros::Subscriber> subscribeToWheels(ros::NodeHandle& node_handle, WheelSource source,
                                               std::uint32_t queue, const WheelHandlers& handlers) {
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  const std::vector<std::string> topics = wheelTopics(source);
  const auto one = [&](const auto& handler) -> std::vector<ros::Subscriber> {
    return {node_handle.subscribe(topics[0], queue, handler, {}, hints)};
  };
  if (source == WheelSource::kTicks) return one(handlers.ticks);
  if (source == WheelSource::kJointStates) return one(handlers.joint_states);
  if (source == WheelSource::kOdometry) return one(handlers.odometry);
  std::vector<ros::Subscriber> subscribers;
  for (const core::WheelSide side : {core::WheelSide::kLeft, core::WheelSide::kRight}) {
    const boost::function<void(const WheelCountEvent&)> callback =
        [side, handle = handlers.wheel](const WheelCountEvent& event) { handle(side, event); };
    subscribers.push_back(node_handle.subscribe<topic_tools::ShapeShifter, const WheelCountEvent&>(
        topics[side == core::WheelSide::kLeft ? 0 : 1], queue, callback, {}, hints));
  }
  return subscribers;
}

}  // namespace bearing_calibration_ros
