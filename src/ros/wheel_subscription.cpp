#include "bearing_calibration_ros/wheel_subscription.h"

#include <boost/function.hpp>

namespace bearing_calibration_ros {
namespace {

/// Small messages that must not wait for each other.
ros::TransportHints hints() { return ros::TransportHints().tcpNoDelay(); }

ros::Subscriber subscribeToWheel(ros::NodeHandle& node_handle, const std::string& topic,
                                 std::uint32_t queue, core::WheelSide side,
                                 const WheelHandlers& handlers) {
  using Callback = boost::function<void(const WheelCountEvent&)>;
  const Callback callback = [side, handle = handlers.wheel](const WheelCountEvent& event) {
    handle(side, event);
  };
  return node_handle.subscribe<topic_tools::ShapeShifter, const WheelCountEvent&>(
      topic, queue, callback, ros::VoidConstPtr(), hints());
}

template <typename Message, typename Handler>
ros::Subscriber subscribeTo(ros::NodeHandle& node_handle, const std::string& topic,
                            std::uint32_t queue, const Handler& handler) {
  using Pointer = boost::shared_ptr<Message const>;
  return node_handle.subscribe<Message>(
      topic, queue, boost::function<void(const Pointer&)>(handler), ros::VoidConstPtr(), hints());
}

}  // namespace

std::vector<std::string> wheelTopics(WheelSource source) {
  switch (source) {
    case WheelSource::kTicks:
      return {"wheel_ticks"};
    case WheelSource::kJointStates:
      return {"joint_states"};
    case WheelSource::kSeparateTicks:
      return {"left_ticks", "right_ticks"};
  }
  return {};
}

std::vector<ros::Subscriber> subscribeToWheels(ros::NodeHandle& node_handle, WheelSource source,
                                               std::uint32_t queue, const WheelHandlers& handlers) {
  const std::vector<std::string> topics = wheelTopics(source);
  switch (source) {
    case WheelSource::kTicks:
      return {subscribeTo<msg::WheelTicks>(node_handle, topics.front(), queue, handlers.ticks)};
    case WheelSource::kJointStates:
      return {subscribeTo<sensor_msgs::JointState>(node_handle, topics.front(), queue,
                                                   handlers.joint_states)};
    case WheelSource::kSeparateTicks:
      return {
          subscribeToWheel(node_handle, topics.front(), queue, core::WheelSide::kLeft, handlers),
          subscribeToWheel(node_handle, topics.back(), queue, core::WheelSide::kRight, handlers)};
  }
  return {};
}

}  // namespace bearing_calibration_ros
