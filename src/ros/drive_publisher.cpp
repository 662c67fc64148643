#include "bearing_calibration_ros/drive_publisher.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>

#include <cmath>
#include <limits>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

geometry_msgs::PoseStamped poseMessage(const core::Pose2& pose, const std_msgs::Header& header) {
  geometry_msgs::PoseStamped message;
  message.header = header;
  message.pose = poseFromPlane(pose);
  return message;
}

}  // namespace

geometry_msgs::Twist twistFrom(const core::WheelSpeeds& speeds, double wheel_separation_m) {
  geometry_msgs::Twist twist;
  twist.linear.x = 0.5 * (speeds.left_mps + speeds.right_mps);
  twist.angular.z = (speeds.right_mps - speeds.left_mps) / wheel_separation_m;
  return twist;
}

msg::CalibrationDriveFeedback feedbackFrom(const core::CalibrationDriver& driver,
                                           const msg::CalibrationEstimate& estimate) {
  msg::CalibrationDriveFeedback feedback;
  feedback.state_text = estimate.state_text + ": " + estimate.advice;
  feedback.x_stddev_m = estimate.x_stddev_m;
  feedback.y_stddev_m = estimate.y_stddev_m;
  feedback.yaw_stddev_rad = estimate.yaw_stddev_rad;
  Eigen::Vector3d expected = Eigen::Vector3d::Constant(kNone);
  if (driver.plan()) expected = driver.plan()->expected.covariance.diagonal().cwiseSqrt();
  feedback.expected_x_stddev_m = expected.x();
  feedback.expected_y_stddev_m = expected.y();
  feedback.expected_yaw_stddev_rad = expected.z();
  feedback.light_distance_m = std::hypot(estimate.light_x_m, estimate.light_y_m);
  feedback.time_s = driver.timeSeconds();
  feedback.path_m = driver.pathMeters();
  return feedback;
}

msg::CalibrationDriveResult resultFrom(const core::CalibrationDriver& driver,
                                       const msg::CalibrationEstimate& estimate) {
  msg::CalibrationDriveResult result;
  result.end = static_cast<std::uint8_t>(driver.ended());
  result.end_text = std::string(core::nameOf(driver.ended())) + ": " + describe(driver.ended());
  result.time_s = driver.timeSeconds();
  result.path_m = driver.pathMeters();
  result.x_stddev_m = estimate.x_stddev_m;
  result.y_stddev_m = estimate.y_stddev_m;
  result.yaw_stddev_rad = estimate.yaw_stddev_rad;
  return result;
}

DrivePublisher::DrivePublisher(ros::NodeHandle private_node_handle, const std::string& start_frame)
    : path_publisher_(private_node_handle.advertise<nav_msgs::Path>("path", 1, true)),
      way_publisher_(private_node_handle.advertise<nav_msgs::Path>("way_ahead", 1, true)),
      expected_publisher_(private_node_handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(
          "expected_base_from_camera", 1)) {
  path_.header.frame_id = start_frame;
}

void DrivePublisher::extendPath(const core::Pose2& start_from_base, const ros::Time& now) {
  constexpr double kSpacing_m = 0.02;  // fine enough for the eye, and no growth while it stands
  path_.header.stamp = now;
  const geometry_msgs::PoseStamped pose = poseMessage(start_from_base, path_.header);
  if (!path_.poses.empty()) {
    const geometry_msgs::Point& last = path_.poses.back().pose.position;
    const double way_m = std::hypot(pose.pose.position.x - last.x, pose.pose.position.y - last.y);
    if (way_m < kSpacing_m) return;
  }
  path_.poses.push_back(pose);
}

/// The start hangs on the base, not the base on the start: the base has a parent of its own.
void DrivePublisher::placeStart(const core::Pose2& start_from_base, const std::string& base_frame,
                                const ros::Time& now) {
  if (base_frame.empty()) return;
  tf_broadcaster_.sendTransform(transformFromPlane(start_from_base.inverse(), stampFromRos(now),
                                                   base_frame, path_.header.frame_id));
}

void DrivePublisher::publish(const core::CalibrationDriver& driver, const std::string& base_frame,
                             const ros::Time& now) {
  extendPath(driver.startFromBase(), now);
  placeStart(driver.startFromBase(), base_frame, now);
  path_publisher_.publish(path_);
  nav_msgs::Path way;
  way.header = path_.header;
  for (const core::Pose2& pose : driver.wayAhead()) {
    way.poses.push_back(poseMessage(pose, way.header));
  }
  way_publisher_.publish(way);
  if (!driver.plan()) return;
  // z, roll and pitch play no part here: they are shown flat and with no variance.
  expected_publisher_.publish(
      poseFromMount(driver.plan()->expected, {}, stampFromRos(now), base_frame));
}

}  // namespace bearing_calibration_ros
