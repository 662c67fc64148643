#pragma once

#include <bearing_calibration/CalibrationEstimate.h>
#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>
#include <bearing_calibration/WheelTicks.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>

#include <cstdint>
#include <optional>
#include <string>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/output/unestimated_mount.h"
#include "bearing_calibration_ros/namespaces.h"

/// Messages to the core's types and back. Nothing is judged here: NaN, infinity and absurd numbers
/// pass unchanged, the core refuses them. Stamps are exact to the nanosecond.
namespace bearing_calibration_ros {

core::Stamp stampFromRos(const ros::Time& time);

/// @throws std::invalid_argument for a stamp that ros::Time cannot hold (before 1970, after 2106).
ros::Time rosFromStamp(core::Stamp stamp);

core::WheelCounts countsFromMessage(const msg::WheelTicks& message);

/// Names of the wheels' joints in a sensor_msgs/JointState.
struct WheelJoints {
  std::string left;
  std::string right;
};

/// None when one of the joints is not there, or has no position.
std::optional<core::WheelAngles> anglesFromMessage(const sensor_msgs::JointState& message,
                                                   const WheelJoints& joints);

/// Whether the message speaks of one of the joints at all.
bool namesEither(const sensor_msgs::JointState& message, const WheelJoints& joints);

/// "a, b, c" for people.
std::string jointNames(const sensor_msgs::JointState& message);

core::BearingSet bearingsFromMessage(const msg::LightBearings& message);

msg::PredictedBearing messageFromPrediction(const core::BearingPrediction& prediction,
                                            const std::string& sensor_frame);

/// "bearings stamp in the future: 3; ..." over both streams, empty when nothing was refused or
/// changed. Joint states without the wheels never reach the core, so they are counted beside it.
std::string rejectionsText(const core::CalibrationResult& result,
                           std::uint32_t joint_states_without_wheels);

/// NaN where there is no estimate yet.
msg::CalibrationEstimate messageFromResult(const core::CalibrationResult& result,
                                           std::uint32_t joint_states_without_wheels,
                                           const std::string& base_frame);

/// Light and mount of such a message, with the errors of clock and wheels; none where it has no
/// estimate yet.
std::optional<core::StateEstimate> robotFromMessage(const msg::CalibrationEstimate& message);

/// A pose of the plane at a height above it.
geometry_msgs::Pose poseFromPlane(const core::Pose2& pose, double z_m = 0.0);

/// The transform that maps points from the child frame to the parent frame.
geometry_msgs::TransformStamped transformFromPlane(const core::Pose2& parent_from_child,
                                                   core::Stamp stamp,
                                                   const std::string& parent_frame,
                                                   const std::string& child_frame);

/// The sensor's pose in the base frame; 6x6 covariance row-major in (x, y, z, roll, pitch, yaw)
/// (REP 103). What is not estimated enters with its configured variance, uncorrelated.
geometry_msgs::PoseWithCovarianceStamped poseFromMount(const core::MountEstimate& base_from_sensor,
                                                       const core::UnestimatedMount& unestimated,
                                                       core::Stamp stamp,
                                                       const std::string& base_frame);

/// The transform that maps points from the child (sensor) frame to the base frame.
geometry_msgs::TransformStamped transformFromPose(
    const geometry_msgs::PoseWithCovarianceStamped& base_from_sensor,
    const std::string& sensor_frame);

}  // namespace bearing_calibration_ros
