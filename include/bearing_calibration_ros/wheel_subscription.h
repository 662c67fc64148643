#pragma once

#include <bearing_calibration/WheelTicks.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>
#include <topic_tools/shape_shifter.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/wheel_params.h"

namespace bearing_calibration_ros {

/// The count of one wheel as it came, with the moment of its receipt.
using WheelCountEvent = ros::MessageEvent<topic_tools::ShapeShifter const>;

/// Who takes the wheels' readings; one of them is called, by the source.
struct WheelHandlers {
  std::function<void(const msg::WheelTicksConstPtr&)> ticks;
  std::function<void(const sensor_msgs::JointStateConstPtr&)> joint_states;
  std::function<void(core::WheelSide, const WheelCountEvent&)> wheel;
};

/// Names of the topics before they are resolved; two for separate ticks, left and right.
std::vector<std::string> wheelTopics(WheelSource source);

/// Subscribes to what the source names.
std::vector<ros::Subscriber> subscribeToWheels(ros::NodeHandle& node_handle, WheelSource source,
                                               std::uint32_t queue, const WheelHandlers& handlers);

}  // namespace bearing_calibration_ros
