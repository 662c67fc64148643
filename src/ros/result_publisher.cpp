#include "bearing_calibration_ros/result_publisher.h"

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {

ResultPublisher::ResultPublisher(ros::NodeHandle private_node_handle,
                                 const CalibrationNodeConfig& config)
    : frames_(config.frames),
      unestimated_mount_(config.unestimated_mount),
      output_(config.output),
      estimate_publisher_(
          private_node_handle.advertise<msg::CalibrationEstimate>("estimate", 1, true)),
      pose_publisher_(private_node_handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(
          "base_from_camera", 1, true)),
      transform_publisher_(
          private_node_handle.advertise<geometry_msgs::TransformStamped>("transform", 1, true)) {
  if (output_.publish_tf) tf_broadcaster_ = std::make_unique<tf2_ros::TransformBroadcaster>();
}

void ResultPublisher::offer(const core::Calibrator& calibrator,
                            std::uint32_t joint_states_without_wheels) {
  const ros::WallDuration since_last = ros::SteadyTime::now() - last_published_;
  if (has_news_ && since_last.toSec() * output_.max_rate_hz >= 1.0) {
    publish(calibrator.result(), joint_states_without_wheels);
  }
}

void ResultPublisher::publish(const core::CalibrationResult& result,
                              std::uint32_t joint_states_without_wheels) {
  has_news_ = false;
  last_published_ = ros::SteadyTime::now();
  estimate_publisher_.publish(messageFromResult(result, joint_states_without_wheels, frames_.base));
  if (result.base_from_sensor && result.stamp > last_pose_stamp_) {
    publishPose(*result.base_from_sensor, result.stamp);
  }
}

void ResultPublisher::publishPose(const core::MountEstimate& base_from_sensor, core::Stamp stamp) {
  last_pose_stamp_ = stamp;
  const geometry_msgs::PoseWithCovarianceStamped pose =
      poseFromMount(base_from_sensor, unestimated_mount_, stamp, frames_.base);
  pose_publisher_.publish(pose);
  transform_publisher_.publish(transformFromPose(pose, frames_.sensor));
}

void ResultPublisher::sendTransform(const core::CalibrationResult& result, const ros::Time& now) {
  if (!tf_broadcaster_ || !result.base_from_sensor || now <= last_transform_) return;
  last_transform_ = now;
  tf_broadcaster_->sendTransform(transformFromPose(
      poseFromMount(*result.base_from_sensor, unestimated_mount_, stampFromRos(now), frames_.base),
      output_.tf_child_frame));
}

void ResultPublisher::restartStamps() {
  last_pose_stamp_ = {};
  last_transform_ = {};
}

}  // namespace bearing_calibration_ros
