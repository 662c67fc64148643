#pragma once

#include <bearing_calibration/WheelTicks.h>
#include <nav_msgs/Odometry.h>
#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <sensor_msgs/JointState.h>
#include <topic_tools/shape_shifter.h>

#include <boost/function.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration_ros/namespaces.h"

/// The wheels' readings: what their messages are, where they come from, and
/// what they say. Nothing is judged here: the core refuses what cannot be.
namespace bearing_calibration_ros {

enum class WheelSource : std::uint8_t {
  kTicks,          ///< bearing_calibration/WheelTicks
  kJointStates,    ///< sensor_msgs/JointState
  kSeparateTicks,  ///< the count of each wheel on a topic of its own
  kOdometry,       ///< nav_msgs/Odometry
};

/// Names of the wheels' joints in a sensor_msgs/JointState.
struct WheelJoints {
  std::string left;
  std::string right;
};

/// Of the parameter group `wheels` of config/calibration.yaml.
struct WheelInput {
  WheelSource source = WheelSource::kTicks;
  WheelJoints joints;

  void declare(core::Parameters& params);
};

core::WheelCounts countsFromMessage(const msg::WheelTicks& message);

/// None when one of the joints is not there, or has no position.
std::optional<core::WheelAngles> anglesFromMessage(const sensor_msgs::JointState& message,
                                                   const WheelJoints& joints);
/// Whether the message speaks of one of the joints at all.
bool namesEither(const sensor_msgs::JointState& message, const WheelJoints& joints);
/// A sentence for people that names the joints that are wanted, and those of the message.
std::string describeMissing(const WheelJoints& joints, const sensor_msgs::JointState& message);

core::OdometryPose odometryFromMessage(const nav_msgs::Odometry& message);

/// Whether a message of this definition is the count of one wheel: an integer
/// `data`, first of its fields or after a Header. So are std_msgs' Int16, Int32
/// and so on, and Duckietown's WheelEncoderStamped.
bool isWheelCount(const std::string& message_definition);
/// The count of one wheel, with the stamp of its header, or of its receipt where it has none.
/// @throws std::invalid_argument that names the type, for a message that is no such count, or
/// is cut short.
core::WheelCount countFromMessage(const topic_tools::ShapeShifter& message,
                                  const ros::Time& received);

/// The count of one wheel as it came, with the moment of its receipt.
using WheelCountEvent = ros::MessageEvent<topic_tools::ShapeShifter const>;

/// Who takes the wheels' messages; one of them is called, by the source.
struct WheelHandlers {
  boost::function<void(const msg::WheelTicksConstPtr&)> ticks;
  boost::function<void(const sensor_msgs::JointStateConstPtr&)> joint_states;
  boost::function<void(core::WheelSide, const WheelCountEvent&)> wheel;
  boost::function<void(const nav_msgs::OdometryConstPtr&)> odometry;
};

/// Names of the topics before they are resolved; two for separate ticks, left and right.
std::vector<std::string> wheelTopics(WheelSource source);
std::vector<ros::Subscriber> subscribeToWheels(ros::NodeHandle& node_handle, WheelSource source,
                                               std::uint32_t queue, const WheelHandlers& handlers);

}  // namespace bearing_calibration_ros
