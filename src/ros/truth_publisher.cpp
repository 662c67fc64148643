#include "bearing_calibration_ros/truth_publisher.h"

#include <bearing_calibration/LightBearings.h>
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseStamped.h>
#include <visualization_msgs/Marker.h>

#include <limits>
#include <string>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

constexpr std::uint32_t kQueue = 100;  // ten seconds of images
constexpr bool kLatched = true;

geometry_msgs::PoseStamped poseMessage(const core::Pose2& pose, double z_m, core::Stamp stamp,
                                       const std::string& frame) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = rosFromStamp(stamp);
  message.header.frame_id = frame;
  message.pose = poseFromPlane(pose, z_m);
  return message;
}

/// An arrow along the sensor's x axis, for RViz.
visualization_msgs::Marker mountMarker(const core::Pose2& base_from_sensor, double z_m,
                                       const std::string& base_frame) {
  visualization_msgs::Marker marker;
  marker.header.frame_id = base_frame;  // stamp zero: of the newest transform, whenever one looks
  marker.frame_locked = true;
  marker.ns = "truth";
  marker.type = visualization_msgs::Marker::ARROW;
  marker.pose = poseFromPlane(base_from_sensor, z_m);
  marker.scale.x = 0.12;  // its length
  marker.scale.y = marker.scale.z = 0.002;
  marker.color.g = 0.75F;
  marker.color.b = 0.45F;
  marker.color.a = 1.0F;
  return marker;
}

/// The azimuths alone: nothing else of a LightBearing is known without a camera.
msg::LightBearings bearingsMessage(const core::BearingSet& bearings, const std::string& frame) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  msg::LightBearings message;
  message.header.stamp = rosFromStamp(bearings.stamp);
  message.header.frame_id = frame;
  for (const core::Bearing& bearing : bearings.candidates) {
    msg::LightBearing candidate;
    candidate.azimuth = bearing.azimuth_rad;
    candidate.azimuth_variance = bearing.azimuth_variance_rad2;
    candidate.image_radius = candidate.image_radius_variance = kNone;
    candidate.elevation = candidate.elevation_variance = kNone;
    candidate.light_id = bearing.light_id;
    candidate.probability = 1.0F;
    message.candidates.push_back(candidate);
  }
  return message;
}

}  // namespace

TruthPublisher::TruthPublisher(ros::NodeHandle private_node_handle,
                               const SimulationNodeConfig& config, core::Stamp start)
    : frames_(config.frames) {
  ros::NodeHandle truth(private_node_handle, "truth");
  mount_ = truth.advertise<geometry_msgs::PoseStamped>("base_from_camera", 1, kLatched);
  marker_ = truth.advertise<visualization_msgs::Marker>("marker", 1, kLatched);
  light_ = truth.advertise<geometry_msgs::PointStamped>("light", 1, kLatched);
  base_ = truth.advertise<geometry_msgs::PoseStamped>("base", kQueue);
  bearings_ = truth.advertise<msg::LightBearings>("bearings", kQueue);
  mount_.publish(
      poseMessage(config.robot.base_from_sensor, config.mount_height_m, start, frames_.base));
  marker_.publish(mountMarker(config.robot.base_from_sensor, config.mount_height_m, frames_.base));
  if (config.scene.lights.empty()) return;
  const core::Light& light = config.scene.lights.front();
  geometry_msgs::PointStamped message;
  message.header.stamp = rosFromStamp(start);
  message.header.frame_id = frames_.world;
  message.point.x = light.position_m.x();
  message.point.y = light.position_m.y();
  message.point.z = config.mount_height_m + light.height_m;
  light_.publish(message);
}

void TruthPublisher::publish(const core::RobotSimulator& simulator) {
  base_.publish(poseMessage(simulator.worldFromBase(), 0.0, simulator.now(), frames_.world));
  if (bearings_.getNumSubscribers() == 0) return;
  const core::BearingSet exact =
      core::exactBearings(simulator.lights(), simulator.worldFromSensor(), simulator.now());
  bearings_.publish(bearingsMessage(exact, frames_.sensor));
}

}  // namespace bearing_calibration_ros
