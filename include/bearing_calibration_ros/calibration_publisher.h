#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/output/visualisation.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/visualisation_markers.h"

namespace bearing_calibration_ros {

/// Publishes what a calibration knows, as often as the rates allow:
/// - ~estimate, and for each newly fused bearing and each fit ~base_from_camera and ~transform,
///   latched, so that who comes late sees the last one; on request the mount on /tf, too;
/// - ~predicted_bearing: where the sensor should see the light, by the newest wheel readings;
/// - ~markers, latched, and while somebody listens to them the start frame on /tf. It hangs on the
///   base, not the base on it: the base may have a parent already (REP 105), and a frame has one.
class CalibrationPublisher {
 public:
  /// @param config  that outlives this
  CalibrationPublisher(ros::NodeHandle private_node_handle, const CalibrationNodeConfig& config,
                       core::Calibrator* calibrator);

  /// Something was fused or refused, or the wheels are there: the next offerEstimate() may publish.
  void expectNews() { has_news_ = true; }
  /// Joint states without the wheels never reach the core: they are counted here.
  void countJointStateWithoutWheels() {
    ++joint_states_without_wheels_;
    expectNews();
  }
  /// Only when it publishes the result is asked for: to build one takes longer than to follow a
  /// wheel reading.
  void offerEstimate();
  /// Publishes the estimate whatever there is; the poses still only when they are news.
  void publishEstimate();
  /// Sends the mount to /tf when that is asked for, an estimate is there, and `now` is a new
  /// moment: TF takes each stamp once. Never to /tf_static: what is there cannot be taken back.
  void sendTransform(const ros::Time& now);

  /// For the moment of the newest wheel readings, when someone listens and there is an estimate.
  void offerPrediction(core::Stamp newest_wheels);
  /// Draws and publishes what there is now.
  void offerMarkers();

  /// @param silence  which input is silent; empty when none is
  void diagnose(const std::string& silence, diagnostic_updater::DiagnosticStatusWrapper* status);

  /// The calibration begins anew.
  void restart();
  /// The stamps begin anew with the clock.
  void restartStamps();

 private:
  geometry_msgs::PoseWithCovarianceStamped mountAt(core::Stamp stamp,
                                                   const core::MountEstimate& mount) const;
  void sendStart(const core::BasePlace& place);

  const CalibrationNodeConfig& config_;
  core::Calibrator* const calibrator_;
  core::Visualiser visualiser_;
  ros::Publisher estimate_publisher_, pose_publisher_, transform_publisher_;
  ros::Publisher prediction_publisher_, markers_publisher_;
  /// None until it is used: who wants no transforms gets no topic of them.
  std::unique_ptr<tf2_ros::TransformBroadcaster> tf_broadcaster_;
  bool has_news_ = false;
  std::uint32_t joint_states_without_wheels_ = 0;
  std::uint32_t remarks_before_ = 0;  ///< on inputs, at the last diagnostics
  ros::SteadyTime last_published_, last_drawn_;
  core::Stamp last_pose_, last_predicted_, last_start_;
  core::Stamp last_fused_;                         ///< at the last pose; its own may be later
  std::optional<core::MountEstimate> last_mount_;  ///< of the last pose
  ros::Time last_transform_;
};

}  // namespace bearing_calibration_ros
