#pragma once

#include <bearing_calibration/LightBearings.h>
#include <bearing_calibration/WheelTicks.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/JointState.h>
#include <tf2_msgs/TFMessage.h>
#include <topic_tools/shape_shifter.h>

#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "bearing_calibration/odometry/wheel_readings.h"
#include "tools/owner/bag_topics.h"
#include "tools/owner/bounded_queue.h"

namespace bearing_calibration::core {

/// The count of one wheel on a topic of its own.
struct BagWheelCount {
  WheelSide side = WheelSide::kLeft;
  topic_tools::ShapeShifter::ConstPtr count;
};

/// A message of a bag as it was recorded.
struct BagMessage {
  ros::Time received;
  std::variant<WheelTicksConstPtr, sensor_msgs::JointStateConstPtr, LightBearingsConstPtr,
               sensor_msgs::ImageConstPtr, sensor_msgs::CompressedImageConstPtr,
               geometry_msgs::PoseWithCovarianceStampedConstPtr, nav_msgs::OdometryConstPtr,
               sensor_msgs::CameraInfoConstPtr, tf2_msgs::TFMessageConstPtr, BagWheelCount>
      content;
};

/// Reads a bag on a thread of its own, in the bag's order, a bounded way ahead of who takes its
/// messages.
class BagReader {
 public:
  /// Opens the bag; nothing is read yet.
  /// @throws std::runtime_error for a bag that lacks a topic, or cannot be read: with its cure
  BagReader(const std::string& path, const BagTopics& wanted,
            bearing_calibration_ros::WheelSource source);
  ~BagReader();
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;

  const BagTopics& topics() const { return topics_; }
  /// Messages on these topics.
  std::uint64_t size() { return view_.size(); }

  /// The next messages, a handful; none at the end.
  /// @throws std::runtime_error for a bag that cannot be read on: with its cure
  std::vector<BagMessage> next();

  /// Time of reading so far, without waiting [s]; whole after the last next().
  double readingSeconds() const { return reading_s_; }

 private:
  void read();
  void readAll();
  std::optional<BagMessage> readMessage(const rosbag::MessageInstance& message) const;

  std::string path_;
  bearing_calibration_ros::WheelSource source_;
  rosbag::Bag bag_;
  rosbag::View view_;
  BagTopics topics_;
  double reading_s_ = 0.0;  ///< written by the thread, until it has finished
  std::exception_ptr error_;
  BoundedQueue<std::vector<BagMessage>> queue_;
  std::thread thread_;  ///< last: it uses the others
};

}  // namespace bearing_calibration::core
