#pragma once

#include <ros/node_handle.h>
#include <ros/publisher.h>

#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/simulation_params.h"

namespace bearing_calibration_ros {

/// What the simulation knows and the calibration is to find: ~truth/base_from_camera and
/// ~truth/light (latched), the former as ~truth/marker too, ~truth/base and ~truth/bearings.
class TruthPublisher {
 public:
  TruthPublisher(ros::NodeHandle private_node_handle, const SimulationNodeConfig& config,
                 core::Stamp start);

  /// Pose of the base and exact bearings of this moment.
  void publish(const core::RobotSimulator& simulator);

 private:
  SimulatedFrames frames_;
  ros::Publisher mount_;
  ros::Publisher marker_;
  ros::Publisher light_;
  ros::Publisher base_;
  ros::Publisher bearings_;
};

}  // namespace bearing_calibration_ros
