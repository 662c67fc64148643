#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <cstdint>
#include <functional>

#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/waiting_work.h"

namespace bearing_calibration_ros {

/// The images of the topic `image`, raw or of another transport (the private parameter
/// image_transport). Those that wait while one is worked on are few, and the newest.
///
/// Threading: all callbacks are those of the node handle's queue, which must serve one at a time.
class ImageInput {
 public:
  /// @param queue  images that may wait
  /// @param use    takes each image; throws nothing
  /// @param refuse says why one could not be decoded
  ImageInput(const ros::NodeHandle& node_handle, const ros::NodeHandle& private_node_handle,
             int queue, std::function<void(const sensor_msgs::ImageConstPtr&)> use,
             std::function<void(const ImageRefusal&)> refuse);

  /// Images for which newer ones had come before their turn.
  std::uint64_t dropped() const { return waiting_.dropped(); }
  bool isSilent() const;

 private:
  void takeCompressed(const sensor_msgs::CompressedImage& compressed);
  void add(const WaitingWork::Work& work);

  std::function<void(const sensor_msgs::ImageConstPtr&)> use_;
  std::function<void(const ImageRefusal&)> refuse_;
  SilenceWatch silence_;
  WaitingWork waiting_;
  image_transport::ImageTransport transport_;
  image_transport::Subscriber subscriber_;  ///< the last ones: their callbacks use the others
  ros::Subscriber compressed_subscriber_;
};

}  // namespace bearing_calibration_ros
