#include "bearing_calibration_ros/truth_publisher.h"

#include <bearing_calibration/LightBearings.h>
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseStamped.h>
#include <tf2/LinearMath/Quaternion.h>
#include <tf2_geometry_msgs/tf2_geometry_msgs.h>

#include <limits>
#include <string>

#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration;

constexpr std::uint32_t kQueue = 100;  // ten seconds of images
constexpr bool kLatched = true;

geometry_msgs::PoseStamped poseMessage(const core::Pose2& pose, double z_m, core::Stamp stamp,
                                       const std::string& frame) {
  geometry_msgs::PoseStamped message;
  message.header.stamp = rosFromStamp(stamp);
  message.header.frame_id = frame;
  message.pose.position.x = pose.position_m.x();
  message.pose.position.y = pose.position_m.y();
  message.pose.position.z = z_m;
  tf2::Quaternion orientation;
  orientation.setRPY(0.0, 0.0, pose.yaw_rad);
  message.pose.orientation = tf2::toMsg(orientation);
  return message;
}

/// The azimuths alone: nothing else of a LightBearing is known without a camera.
core::LightBearings bearingsMessage(const core::BearingSet& bearings, const std::string& frame) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  core::LightBearings message;
  message.header.stamp = rosFromStamp(bearings.stamp);
  message.header.frame_id = frame;
  for (const core::Bearing& bearing : bearings.candidates) {
    core::LightBearing candidate;
    candidate.azimuth = bearing.azimuth_rad;
    candidate.azimuth_variance = bearing.azimuth_variance_rad2;
    candidate.image_radius = candidate.image_radius_variance = kNone;
    candidate.elevation = candidate.elevation_variance = kNone;
    candidate.light_id = bearing.light_id;
    candidate.quality = 1.0F;
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
  light_ = truth.advertise<geometry_msgs::PointStamped>("light", 1, kLatched);
  base_ = truth.advertise<geometry_msgs::PoseStamped>("base", kQueue);
  bearings_ = truth.advertise<core::LightBearings>("bearings", kQueue);
  mount_.publish(
      poseMessage(config.robot.base_from_sensor, config.mount_height_m, start, frames_.base));
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
