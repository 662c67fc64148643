#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <cstdint>
#include <memory>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Publishes results: ~estimate, and for each newly fused bearing ~base_from_camera and ~transform.
/// All three topics are latched, so that who comes late sees the last one. On request there is TF,
/// too.
class ResultPublisher {
 public:
  ResultPublisher(ros::NodeHandle private_node_handle, const CalibrationNodeConfig& config);

  /// Something was fused or refused, or the wheels are there: the next offer() may publish.
  void expectNews() { has_news_ = true; }
  /// Publishes when there is news and the rate allows it. Only then the result is asked for: to
  /// build one takes longer than to follow a wheel reading.
  void offer(const core::Calibrator& calibrator, std::uint32_t joint_states_without_wheels);
  /// Publishes the estimate whatever there is; the poses still only when their stamp is a new one.
  void publish(const core::CalibrationResult& result, std::uint32_t joint_states_without_wheels);

  /// Sends the mount to /tf when that is asked for, an estimate is there, and `now` is a new
  /// moment: TF takes each stamp once. Never to /tf_static: what is there cannot be taken back.
  void sendTransform(const core::CalibrationResult& result, const ros::Time& now);

  /// The stamps begin anew with the clock.
  void restartStamps();

 private:
  void publishPose(const core::MountEstimate& base_from_sensor, core::Stamp stamp);

  FrameNames frames_;
  core::UnestimatedMount unestimated_mount_;
  OutputConfig output_;
  ros::Publisher estimate_publisher_;
  ros::Publisher pose_publisher_;
  ros::Publisher transform_publisher_;
  std::unique_ptr<tf2_ros::TransformBroadcaster> tf_broadcaster_;  ///< none unless on request
  bool has_news_ = false;
  ros::SteadyTime last_published_;
  core::Stamp last_pose_stamp_;
  ros::Time last_transform_;
};

}  // namespace bearing_calibration_ros
