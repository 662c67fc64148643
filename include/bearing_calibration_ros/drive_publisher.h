#pragma once

#include <actionlib/server/action_server.h>
#include <bearing_calibration/CalibrationDriveAction.h>
#include <bearing_calibration/CalibrationEstimate.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <geometry_msgs/Twist.h>
#include <nav_msgs/Path.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <tf2_ros/transform_broadcaster.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <string>
#include <utility>

#include "bearing_calibration/planning/calibration_driver.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/result_messages.h"

namespace bearing_calibration_ros {

inline geometry_msgs::Twist twistFrom(const core::WheelSpeeds& speeds, double wheel_separation_m) {
  geometry_msgs::Twist twist;
  twist.linear.x = 0.5 * (speeds.left_mps + speeds.right_mps);
  twist.angular.z = (speeds.right_mps - speeds.left_mps) / wheel_separation_m;
  return twist;
}

/// The way to cmd_vel. Once it is closed nothing but standing passes: a control loop that still
/// runs while the process ends does not have the last word.
class CommandGate {
 public:
  using Publish = std::function<void(const geometry_msgs::Twist&)>;
  explicit CommandGate(Publish publish) : publish_(std::move(publish)) {}

  /// For any thread: what passes after close() comes after all that has passed before.
  void pass(const geometry_msgs::Twist& twist) {
    const std::lock_guard<std::mutex> lock(mutex_);
    publish_(is_closed_ ? geometry_msgs::Twist() : twist);
  }
  void close() { is_closed_ = true; }
  bool isClosed() const { return is_closed_; }

 private:
  Publish publish_;
  std::mutex mutex_;
  std::atomic<bool> is_closed_{false};
};

/// What the calibration says, as a drive needs it.
inline core::DriveEstimate driveEstimateFrom(const msg::CalibrationEstimate& message) {
  core::DriveEstimate estimate{stampFromRos(message.header.stamp),
                               static_cast<core::CalibrationState>(message.state),
                               robotFromMessage(message)};
  if (estimate.robot) {
    const double nearness_m2 = message.covariance_x_y_yaw[0] - estimate.robot->covariance(0, 0);
    estimate.nearness_stddev_m = std::sqrt(std::max(0.0, nearness_m2));
  }
  return estimate;
}

/// Before the calibration has said anything.
inline msg::CalibrationEstimate noEstimate() {
  msg::CalibrationEstimate none = messageFromResult({}, 0, "");
  none.state_text = "no estimate has come";
  return none;
}

/// What feedback and result both say of the mount.
template <typename Report>
Report reportFrom(const msg::CalibrationEstimate& estimate) {
  Report report;
  report.x_stddev_m = estimate.x_stddev_m;
  report.y_stddev_m = estimate.y_stddev_m;
  report.yaw_stddev_rad = estimate.yaw_stddev_rad;
  return report;
}
/// ... and of a drive.
template <typename Report>
Report reportFrom(const core::CalibrationDriver& driver, const msg::CalibrationEstimate& estimate) {
  auto report = reportFrom<Report>(estimate);
  report.time_s = driver.timeSeconds();
  report.path_m = driver.pathMeters();
  return report;
}

inline msg::CalibrationDriveFeedback feedbackFrom(const core::CalibrationDriver& driver,
                                                  const msg::CalibrationEstimate& estimate) {
  auto feedback = reportFrom<msg::CalibrationDriveFeedback>(driver, estimate);
  feedback.state_text = estimate.state_text + ": " + estimate.advice;
  Eigen::Vector3d expected = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (driver.plan()) expected = driver.plan()->expected.covariance.diagonal().cwiseSqrt();
  feedback.expected_x_stddev_m = expected.x();
  feedback.expected_y_stddev_m = expected.y();
  feedback.expected_yaw_stddev_rad = expected.z();
  feedback.light_distance_m = std::hypot(estimate.light_x_m, estimate.light_y_m);
  return feedback;
}

inline std::string textOf(core::DriveEnd end) {
  return std::string(core::nameOf(end)) + ": " + core::describe(end);
}

inline msg::CalibrationDriveResult resultFrom(const core::CalibrationDriver& driver,
                                              const msg::CalibrationEstimate& estimate) {
  auto result = reportFrom<msg::CalibrationDriveResult>(driver, estimate);
  result.end = static_cast<std::uint8_t>(driver.ended());
  result.end_text = textOf(driver.ended());
  return result;
}

/// The action ~drive, with one goal at a time. Unlike actionlib's own server of that kind it takes
/// a goal whatever its stamp is: clocks begin anew, and those of two computers differ.
class DriveActionServer {
 public:
  using Server = actionlib::ActionServer<msg::CalibrationDriveAction>;
  using Goal = Server::GoalHandle;

  /// @param on_goal    gets each goal, which it has to accept()
  /// @param on_cancel  is called when the goal under way is to end
  DriveActionServer(const ros::NodeHandle& private_node_handle,
                    const std::function<void(const Goal&)>& on_goal,
                    const std::function<void()>& on_cancel)
      : server_(
            private_node_handle, "drive", on_goal,
            [this, on_cancel](const Goal& goal) {
              if (goal == goal_) on_cancel();
            },
            false) {
    server_.start();
  }

  /// The goal before it must have ended.
  void accept(const Goal& goal) {
    goal_ = goal;
    goal_.setAccepted();
  }
  void refuse(const std::string& why, const msg::CalibrationEstimate& estimate) {
    auto result = reportFrom<msg::CalibrationDriveResult>(estimate);
    result.end_text = why;
    goal_.setAborted(result, why);
    goal_ = {};
  }
  void report(const msg::CalibrationDriveFeedback& feedback) {
    if (isActive()) goal_.publishFeedback(feedback);
  }
  /// Ends the goal, where there is one.
  void finish(const msg::CalibrationDriveResult& result) {
    if (!isActive()) return;
    if (result.end == msg::CalibrationDriveResult::CONVERGED) {
      goal_.setSucceeded(result, result.end_text);
    } else if (result.end == msg::CalibrationDriveResult::CANCELLED) {
      goal_.setCanceled(result, result.end_text);
    } else {
      goal_.setAborted(result, result.end_text);
    }
    goal_ = {};
  }

 private:
  bool isActive() const { return goal_.getGoal() != nullptr; }

  Server server_;
  Goal goal_;  ///< the one under way; empty without any
};

/// What people see of a drive: ~path (driven), ~plan (planned), and
/// ~expected_base_from_camera, the mount with the covariance that the plan promises. The frame
/// of the start is sent to /tf as a child of the base, which has a parent of its own, so that RViz
/// can show the paths.
class DrivePublisher {
 public:
  DrivePublisher(ros::NodeHandle private_node_handle, const std::string& start_frame)
      : path_publisher_(private_node_handle.advertise<nav_msgs::Path>("path", 1, true)),
        way_publisher_(private_node_handle.advertise<nav_msgs::Path>("plan", 1, true)),
        expected_publisher_(private_node_handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(
            "expected_base_from_camera", 1)) {
    path_.header.frame_id = start_frame;
  }

  /// A new drive begins: the old path is forgotten.
  void restart() { path_.poses.clear(); }

  void publish(const core::CalibrationDriver& driver, const std::string& base_frame,
               const ros::Time& now) {
    path_.header.stamp = now;
    extendPath(poseIn(path_.header, driver.startFromBase()));
    path_publisher_.publish(path_);
    if (!base_frame.empty()) {
      std_msgs::Header header = path_.header;
      header.frame_id = base_frame;
      tf_broadcaster_.sendTransform(transformFromPose(
          header, poseFromPlane(driver.startFromBase().inverse()), path_.header.frame_id));
    }
    nav_msgs::Path way;
    way.header = path_.header;
    for (const core::Pose2& pose : driver.wayAhead()) way.poses.push_back(poseIn(way.header, pose));
    way_publisher_.publish(way);
    if (!driver.plan()) return;
    // z, roll and pitch play no part here: they are shown flat and with no variance.
    expected_publisher_.publish(
        poseFromMount(driver.plan()->expected, {}, stampFromRos(now), base_frame));
  }

 private:
  static geometry_msgs::PoseStamped poseIn(const std_msgs::Header& header,
                                           const core::Pose2& pose) {
    geometry_msgs::PoseStamped message;
    message.header = header;
    message.pose = poseFromPlane(pose);
    return message;
  }

  void extendPath(const geometry_msgs::PoseStamped& pose) {
    constexpr double kSpacing_m = 0.02;  // fine enough for the eye, and no growth while it stands
    if (!path_.poses.empty()) {
      const geometry_msgs::Point& last = path_.poses.back().pose.position;
      const double way_m = std::hypot(pose.pose.position.x - last.x, pose.pose.position.y - last.y);
      if (way_m < kSpacing_m) return;
    }
    path_.poses.push_back(pose);
  }

  tf2_ros::TransformBroadcaster tf_broadcaster_;
  ros::Publisher path_publisher_;
  ros::Publisher way_publisher_;
  ros::Publisher expected_publisher_;
  nav_msgs::Path path_;
};

}  // namespace bearing_calibration_ros
