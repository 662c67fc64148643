#include "bearing_calibration_ros/calibration_publisher.h"

#include <bearing_calibration/PredictedBearing.h>

#include <algorithm>
#include <chrono>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/result_messages.h"

namespace bearing_calibration_ros {
namespace {

constexpr double kDrawing_hz = 10.0;  // smooth to the eye, and little beside the images
constexpr double kSigmas = 3.0;       // of ellipses and bands
constexpr bool kLatched = true;

/// "CONVERGING", and below it the mount.
std::string stateText(const core::CalibrationResult& result) {
  const std::string state = core::nameOf(result.state);
  if (!result.base_from_sensor) return state;
  const Eigen::Vector3d mean = result.base_from_sensor->mean;
  const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
  const auto line = [&](const char* format, int i, double unit) {
    return core::formatted(format, unit * mean(i), unit * stddev(i));
  };
  return state + line("\nx %.1f +- %.1f mm", 0, 1e3) + line("\ny %.1f +- %.1f mm", 1, 1e3) +
         line("\nyaw %.2f +- %.2f deg", 2, core::degreesFromRadians(1.0));
}

bool isDue(const ros::SteadyTime& last, double rate_hz) {
  return (ros::SteadyTime::now() - last).toSec() * rate_hz >= 1.0;
}

}  // namespace

CalibrationPublisher::CalibrationPublisher(ros::NodeHandle private_node_handle,
                                           const CalibrationNodeConfig& config,
                                           core::Calibrator* calibrator)
    : config_(config),
      calibrator_(calibrator),
      visualiser_(kSigmas),
      estimate_publisher_(
          private_node_handle.advertise<msg::CalibrationEstimate>("estimate", 1, kLatched)),
      pose_publisher_(private_node_handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(
          "base_from_camera", 1, kLatched)),
      transform_publisher_(
          private_node_handle.advertise<geometry_msgs::TransformStamped>("transform", 1, kLatched)),
      prediction_publisher_(
          private_node_handle.advertise<msg::PredictedBearing>("predicted_bearing", 1)),
      markers_publisher_(
          private_node_handle.advertise<visualization_msgs::MarkerArray>("markers", 1, kLatched)) {
  if (config_.output.publish_tf)
    tf_broadcaster_ = std::make_unique<tf2_ros::TransformBroadcaster>();
  calibrator_->observe([this](const core::AssociationOutcome& outcome) {
    visualiser_.see(outcome);
    expectNews();
  });
}

void CalibrationPublisher::offerEstimate() {
  if (has_news_ && isDue(last_published_, config_.output.max_rate_hz)) publishEstimate();
}

void CalibrationPublisher::publishEstimate() {
  has_news_ = false;
  last_published_ = ros::SteadyTime::now();
  const core::CalibrationResult result = calibrator_->result();
  estimate_publisher_.publish(
      messageFromResult(result, joint_states_without_wheels_, config_.frames.base));
  if (!result.base_from_sensor || result.stamp < last_fused_) return;
  // Between two bearings a fit that is taken over changes the mount. No stamp is sent twice.
  const bool is_said = !last_mount_ || result.base_from_sensor == last_mount_;
  if (result.stamp == last_fused_ && is_said) return;
  last_fused_ = result.stamp;
  last_mount_ = result.base_from_sensor;
  last_pose_ = std::max(result.stamp, last_pose_ + std::chrono::nanoseconds(1));
  const auto pose = mountAt(last_pose_, *result.base_from_sensor);
  pose_publisher_.publish(pose);
  transform_publisher_.publish(
      transformFromPose(pose.header, pose.pose.pose, config_.frames.sensor));
}

geometry_msgs::PoseWithCovarianceStamped CalibrationPublisher::mountAt(
    core::Stamp stamp, const core::MountEstimate& mount) const {
  return poseFromMount(mount, config_.unestimated_mount, stamp, config_.frames.base);
}

void CalibrationPublisher::sendTransform(const ros::Time& now) {
  if (!config_.output.publish_tf || now <= last_transform_) return;
  const core::CalibrationResult result = calibrator_->result();
  if (!result.base_from_sensor) return;
  last_transform_ = now;
  const auto pose = mountAt(stampFromRos(now), *result.base_from_sensor);
  tf_broadcaster_->sendTransform(
      transformFromPose(pose.header, pose.pose.pose, config_.output.tf_child_frame));
}

void CalibrationPublisher::offerPrediction(core::Stamp newest_wheels) {
  const double since_last_s = core::secondsFromDuration(newest_wheels - last_predicted_);
  if (since_last_s * config_.output.prediction_rate_hz < 1.0 ||
      prediction_publisher_.getNumSubscribers() == 0) {
    return;
  }
  const core::Duration latency =
      core::durationFromSeconds(config_.calibrator.bearings.latency_s);  // of the sensor's stamps
  const auto prediction = calibrator_->predictBearing(newest_wheels + latency);
  if (!prediction) return;
  last_predicted_ = newest_wheels;
  prediction_publisher_.publish(messageFromPrediction(*prediction, config_.frames.sensor));
}

void CalibrationPublisher::offerMarkers() {
  if (!isDue(last_drawn_, kDrawing_hz)) return;
  last_drawn_ = ros::SteadyTime::now();
  const core::CalibrationResult result = calibrator_->result();
  const auto place = calibrator_->place();
  const core::Visualisation visualisation =
      visualiser_.draw(result, place ? place->start_from_base : core::Pose2{});
  if (markers_publisher_.getNumSubscribers() == 0) return;
  if (place) sendStart(*place);
  markers_publisher_.publish(markersFromVisualisation(visualisation, stateText(result), config_));
}

void CalibrationPublisher::sendStart(const core::BasePlace& place) {
  // The last place holds while the wheels are silent. It is sent again for those who come late, but
  // a stamp is never sent twice.
  constexpr core::Duration kLater = std::chrono::milliseconds(1);
  last_start_ = std::max(place.stamp, last_start_ + kLater);
  if (!tf_broadcaster_) tf_broadcaster_ = std::make_unique<tf2_ros::TransformBroadcaster>();
  std_msgs::Header header;
  header.stamp = rosFromStamp(last_start_);
  header.frame_id = config_.frames.base;
  tf_broadcaster_->sendTransform(transformFromPose(
      header, poseFromPlane(place.start_from_base.inverse()), config_.output.start_frame));
}

void CalibrationPublisher::diagnose(const std::string& silence,
                                    diagnostic_updater::DiagnosticStatusWrapper* status) {
  const core::CalibrationResult result = calibrator_->result();
  const std::uint32_t remarks =
      result.tick_inputs.remarks() + result.bearing_inputs.remarks() + joint_states_without_wheels_;
  fillDiagnostics(result, joint_states_without_wheels_, silence, remarks != remarks_before_,
                  status);
  const core::FitsReport fits = calibrator_->fits();
  status->add("fits taken over", fits.taken);
  status->add("fits dropped", fits.dropped);
  remarks_before_ = remarks;
}

void CalibrationPublisher::restart() {
  joint_states_without_wheels_ = remarks_before_ = 0;
  visualiser_.restart();
  last_predicted_ = last_start_ = {};
}

void CalibrationPublisher::restartStamps() {
  last_pose_ = last_fused_ = {};
  last_mount_.reset();
  last_transform_ = {};
}

}  // namespace bearing_calibration_ros
