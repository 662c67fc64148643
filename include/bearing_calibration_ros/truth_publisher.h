#pragma once

#include <bearing_calibration/LightBearings.h>
#include <geometry_msgs/PointStamped.h>
#include <geometry_msgs/PoseStamped.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <visualization_msgs/Marker.h>

#include <string>

#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// What the simulation knows and the calibration is to find: ~truth/base_from_camera and
/// ~truth/light (latched), the former as ~truth/marker too, ~truth/base and ~truth/bearings.
class TruthPublisher {
 public:
  TruthPublisher(const ros::NodeHandle& private_node_handle, const SimulationNodeConfig& config,
                 core::Stamp start)
      : frames_(config.frames) {
    constexpr std::uint32_t kQueue = 100;  // ten seconds of images
    constexpr bool kLatched = true;
    ros::NodeHandle truth(private_node_handle, "truth");
    mount_ = truth.advertise<geometry_msgs::PoseStamped>("base_from_camera", 1, kLatched);
    marker_ = truth.advertise<visualization_msgs::Marker>("marker", 1, kLatched);
    light_ = truth.advertise<geometry_msgs::PointStamped>("light", 1, kLatched);
    base_ = truth.advertise<geometry_msgs::PoseStamped>("base", kQueue);
    bearings_ = truth.advertise<msg::LightBearings>("bearings", kQueue);
    const auto mount =
        poseMessage(config.robot.base_from_sensor, config.mount_height_m, start, frames_.base);
    mount_.publish(mount);
    marker_.publish(mountMarker(mount));
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

  /// Pose of the base and exact bearings of this moment.
  void publish(const core::RobotSimulator& simulator) {
    base_.publish(poseMessage(simulator.worldFromBase(), 0.0, simulator.now(), frames_.world));
    if (bearings_.getNumSubscribers() == 0) return;
    const core::BearingSet exact =
        core::exactBearings(simulator.lights(), simulator.worldFromSensor(), simulator.now());
    bearings_.publish(messageFromBearings(exact, frames_.sensor));
  }

 private:
  static geometry_msgs::PoseStamped poseMessage(const core::Pose2& pose, double z_m,
                                                core::Stamp stamp, const std::string& frame) {
    geometry_msgs::PoseStamped message;
    message.header.stamp = rosFromStamp(stamp);
    message.header.frame_id = frame;
    message.pose = poseFromPlane(pose, z_m);
    return message;
  }

  /// An arrow along the sensor's x axis, for RViz.
  static visualization_msgs::Marker mountMarker(const geometry_msgs::PoseStamped& mount) {
    visualization_msgs::Marker marker;
    // Stamp zero: of the newest transform, whenever one looks.
    marker.header.frame_id = mount.header.frame_id;
    marker.frame_locked = true;
    marker.ns = "truth";
    marker.type = visualization_msgs::Marker::ARROW;
    marker.pose = mount.pose;
    marker.scale.x = 0.12;  // its length
    marker.scale.y = marker.scale.z = 0.002;
    marker.color.g = 0.75F;
    marker.color.b = 0.45F;
    marker.color.a = 1.0F;
    return marker;
  }

  SimulatedFrames frames_;
  ros::Publisher mount_, marker_, light_, base_, bearings_;
};

}  // namespace bearing_calibration_ros
