#include "bearing_calibration_ros/conversions.h"

#include <tf2/LinearMath/Quaternion.h>
#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <cmath>
#include <stdexcept>

namespace bearing_calibration_ros {
namespace {

template <typename From, typename To>
void assign(From from, To& to) {
  to = static_cast<To>(from);
}

/// Takes each number of a bearing with its place in the message to `pair`.
template <typename Bearing, typename Message, typename Pair>
void forEachNumber(Bearing& bearing, Message& message, Pair pair) {
  pair(bearing.azimuth_rad, message.azimuth);
  pair(bearing.azimuth_variance_rad2, message.azimuth_variance);
  pair(bearing.image_radius_px, message.image_radius);
  pair(bearing.image_radius_variance_px2, message.image_radius_variance);
  pair(bearing.elevation_rad, message.elevation);
  pair(bearing.elevation_variance_rad2, message.elevation_variance);
  pair(bearing.light_id, message.light_id);
  pair(bearing.probability, message.probability);
  pair(bearing.track_probability, message.track_probability);
}

geometry_msgs::Pose poseOf(const Eigen::Vector3d& position_m,
                           const Eigen::Vector3d& roll_pitch_yaw) {
  geometry_msgs::Pose pose;
  pose.position.x = position_m.x();
  pose.position.y = position_m.y();
  pose.position.z = position_m.z();
  tf2::Quaternion orientation;
  orientation.setRPY(roll_pitch_yaw.x(), roll_pitch_yaw.y(), roll_pitch_yaw.z());
  pose.orientation = tf2::toMsg(orientation);
  return pose;
}

}  // namespace

core::Stamp stampFromRos(const ros::Time& time) {
  return core::stampFromNanoseconds(static_cast<std::int64_t>(time.toNSec()));
}

ros::Time rosFromStamp(core::Stamp stamp) {
  const std::int64_t nanoseconds = stamp.time_since_epoch().count();
  if (nanoseconds < 0 || nanoseconds > static_cast<std::int64_t>(ros::TIME_MAX.toNSec())) {
    throw std::invalid_argument("stamp " + std::to_string(nanoseconds) +
                                " ns does not fit into ros::Time");
  }
  return ros::Time().fromNSec(static_cast<std::uint64_t>(nanoseconds));
}

core::BearingSet bearingsFromMessage(const msg::LightBearings& message) {
  core::BearingSet bearings;
  bearings.stamp = stampFromRos(message.header.stamp);
  const auto said = [](double value) { return std::isnan(value) ? 0.0 : value; };
  bearings.geometry = {said(message.harmonic_stddev), said(message.near_per_far),
                       said(message.nearness_stddev)};
  bearings.view = {said(message.view_centre), said(message.view_width)};
  for (const msg::LightBearing& candidate : message.candidates) {
    core::Bearing& bearing = bearings.candidates.emplace_back();
    forEachNumber(bearing, candidate, [](auto& ours, auto theirs) { assign(theirs, ours); });
  }
  return bearings;
}

msg::LightBearings messageFromBearings(const core::BearingSet& set,
                                       const std::string& sensor_frame) {
  msg::LightBearings message;
  message.header.stamp = rosFromStamp(set.stamp);
  message.header.frame_id = sensor_frame;
  message.harmonic_stddev = set.geometry.harmonic_stddev_rad;
  message.near_per_far = set.geometry.near_per_far_m;
  message.nearness_stddev = set.geometry.nearness_stddev_rad_m;
  message.view_centre = set.view.centre_rad;
  message.view_width = set.view.width_rad;
  for (const core::Bearing& bearing : set.candidates) {
    msg::LightBearing& candidate = message.candidates.emplace_back();
    forEachNumber(bearing, candidate, [](auto ours, auto& theirs) { assign(ours, theirs); });
  }
  return message;
}

core::BearingPrediction predictionFromMessage(const msg::PredictedBearing& message) {
  return {stampFromRos(message.header.stamp),
          message.azimuth,
          message.azimuth_variance,
          message.light_id,
          message.distance,
          message.distance_variance};
}

msg::PredictedBearing messageFromPrediction(const core::BearingPrediction& prediction,
                                            const std::string& sensor_frame) {
  msg::PredictedBearing message;
  message.header.stamp = rosFromStamp(prediction.stamp);
  message.header.frame_id = sensor_frame;
  message.azimuth = prediction.azimuth_rad;
  message.azimuth_variance = prediction.azimuth_variance_rad2;
  message.light_id = prediction.light_id;
  message.distance = prediction.distance_m;
  message.distance_variance = prediction.distance_variance_m2;
  return message;
}

core::LaserScan scanFromMessage(const sensor_msgs::LaserScan& message) {
  core::LaserScan scan;
  scan.stamp = stampFromRos(message.header.stamp);
  assign(message.time_increment, scan.ray_period_s);
  assign(message.angle_min, scan.first_ray_rad);
  assign(message.angle_increment, scan.ray_spacing_rad);
  assign(message.range_min, scan.least_range_m);
  assign(message.range_max, scan.most_range_m);
  scan.ranges_m = message.ranges;
  scan.intensities = message.intensities;
  return scan;
}

Eigen::Isometry3d isometryFromMessage(const geometry_msgs::Transform& message) {
  const geometry_msgs::Vector3& t = message.translation;
  const geometry_msgs::Quaternion& q = message.rotation;
  return Eigen::Translation3d(t.x, t.y, t.z) * Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
}

geometry_msgs::Pose poseFromPlane(const core::Pose2& pose, double z_m) {
  return poseOf({pose.position_m.x(), pose.position_m.y(), z_m}, {0.0, 0.0, pose.yaw_rad});
}

geometry_msgs::PoseWithCovarianceStamped poseFromMount(const core::MountEstimate& base_from_sensor,
                                                       const core::UnestimatedMount& unestimated,
                                                       core::Stamp stamp,
                                                       const std::string& base_frame) {
  const Eigen::Vector3d& mean = base_from_sensor.mean;
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header.stamp = rosFromStamp(stamp);
  pose.header.frame_id = base_frame;
  pose.pose.pose = poseOf({mean.x(), mean.y(), unestimated.z_m},
                          {unestimated.roll_rad, unestimated.pitch_rad, mean.z()});

  enum Axis : int { kX, kY, kZ, kRoll, kPitch, kYaw };  // REP 103
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  const int estimated[] = {kX, kY, kYaw};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      covariance(estimated[i], estimated[j]) = base_from_sensor.covariance(i, j);
    }
  }
  covariance(kZ, kZ) = std::pow(unestimated.z_stddev_m, 2);
  covariance(kRoll, kRoll) = std::pow(unestimated.roll_stddev_rad, 2);
  covariance(kPitch, kPitch) = std::pow(unestimated.pitch_stddev_rad, 2);
  fillRowMajor(covariance, &pose.pose.covariance);
  return pose;
}

geometry_msgs::TransformStamped transformFromPose(const std_msgs::Header& header,
                                                  const geometry_msgs::Pose& parent_from_child,
                                                  const std::string& child_frame) {
  geometry_msgs::TransformStamped transform;
  transform.header = header;
  transform.child_frame_id = child_frame;
  transform.transform.translation.x = parent_from_child.position.x;
  transform.transform.translation.y = parent_from_child.position.y;
  transform.transform.translation.z = parent_from_child.position.z;
  transform.transform.rotation = parent_from_child.orientation;
  return transform;
}

}  // namespace bearing_calibration_ros
