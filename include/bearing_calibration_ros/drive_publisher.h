#pragma once

#include <bearing_calibration/CalibrationDriveFeedback.h>
#include <bearing_calibration/CalibrationDriveResult.h>
#include <bearing_calibration/CalibrationEstimate.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <string>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

geometry_msgs::Twist twistFrom(const core::WheelSpeeds& speeds, double wheel_separation_m);

msg::CalibrationDriveFeedback feedbackFrom(const core::CalibrationDriver& driver,
                                           const msg::CalibrationEstimate& estimate);

msg::CalibrationDriveResult resultFrom(const core::CalibrationDriver& driver,
                                       const msg::CalibrationEstimate& estimate);

/// What people see of a drive: ~path (driven), ~way_ahead (planned), and
/// ~expected_base_from_camera, the mount with the covariance that the way ahead promises. The frame
/// of the start is sent to /tf as a child of the base, so that RViz can show the paths.
class DrivePublisher {
 public:
  DrivePublisher(ros::NodeHandle private_node_handle, const std::string& start_frame);

  /// A new drive begins: the old path is forgotten.
  void restart() { path_.poses.clear(); }
  void publish(const core::CalibrationDriver& driver, const std::string& base_frame,
               const ros::Time& now);

 private:
  void extendPath(const core::Pose2& start_from_base, const ros::Time& now);

  void placeStart(const core::Pose2& start_from_base, const std::string& base_frame,
                  const ros::Time& now);

  tf2_ros::TransformBroadcaster tf_broadcaster_;
  ros::Publisher path_publisher_;
  ros::Publisher way_publisher_;
  ros::Publisher expected_publisher_;
  nav_msgs::Path path_;
};

}  // namespace bearing_calibration_ros
