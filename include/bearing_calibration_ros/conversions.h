#pragma once

#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/PredictedBearing.h>
#include <geometry_msgs/Pose.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <sensor_msgs/LaserScan.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/state.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/input/scan_bearings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration_ros/namespaces.h"

/// Messages to the core's types and back. Nothing is judged here: NaN, infinity and absurd numbers
/// pass unchanged, the core refuses them. Stamps are exact to the nanosecond.
namespace bearing_calibration_ros {

core::Stamp stampFromRos(const ros::Time& time);
/// @throws std::invalid_argument for a stamp that ros::Time cannot hold (before 1970, after 2106).
ros::Time rosFromStamp(core::Stamp stamp);

core::BearingSet bearingsFromMessage(const msg::LightBearings& message);
msg::LightBearings messageFromBearings(const core::BearingSet& set,
                                       const std::string& sensor_frame);

core::BearingPrediction predictionFromMessage(const msg::PredictedBearing& message);
msg::PredictedBearing messageFromPrediction(const core::BearingPrediction& prediction,
                                            const std::string& sensor_frame);

core::LaserScan scanFromMessage(const sensor_msgs::LaserScan& message);
Eigen::Isometry3d isometryFromMessage(const geometry_msgs::Transform& message);

/// A matrix, whatever it is stored like, as messages want it: row after row.
template <typename Matrix, typename Array>
void fillRowMajor(const Matrix& matrix, Array* array) {
  constexpr int kRows = Matrix::RowsAtCompileTime;
  constexpr int kColumns = Matrix::ColsAtCompileTime;
  static_assert(sizeof(Array) == kRows * kColumns * sizeof(double));
  Eigen::Map<Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>>(array->data()) = matrix;
}

/// A pose of the plane at a height above it.
geometry_msgs::Pose poseFromPlane(const core::Pose2& pose, double z_m = 0.0);
/// The sensor's pose in the base frame; 6x6 covariance row-major in (x, y, z, roll, pitch, yaw)
/// (REP 103). What is not estimated enters with its configured variance, uncorrelated.
geometry_msgs::PoseWithCovarianceStamped poseFromMount(const core::MountEstimate& base_from_sensor,
                                                       const core::UnestimatedMount& unestimated,
                                                       core::Stamp stamp,
                                                       const std::string& base_frame);
/// The transform that maps points from the child frame to the frame of the pose.
geometry_msgs::TransformStamped transformFromPose(const std_msgs::Header& header,
                                                  const geometry_msgs::Pose& parent_from_child,
                                                  const std::string& child_frame);

}  // namespace bearing_calibration_ros
