#include "bearing_calibration_ros/image_input.h"

#include <cstddef>
#include <exception>
#include <utility>

#include "bearing_calibration_ros/compressed_image.h"

namespace bearing_calibration_ros {

// What is compressed is decoded here: Debian has no plugin of image_transport for it.
ImageInput::ImageInput(const ros::NodeHandle& node_handle,
                       const ros::NodeHandle& private_node_handle, int queue,
                       std::function<void(const sensor_msgs::ImageConstPtr&)> use,
                       std::function<void(const ImageRefusal&)> refuse)
    : use_(std::move(use)),
      refuse_(std::move(refuse)),
      waiting_(node_handle.getCallbackQueue(), static_cast<std::size_t>(queue)),
      transport_(node_handle) {
  // What comes while one image is searched is taken over at once: what is late is dropped there.
  constexpr int kArrivingImages = 20;
  const auto size = static_cast<std::uint32_t>(queue + kArrivingImages);
  const ros::TransportHints no_delay = ros::TransportHints().tcpNoDelay();
  const image_transport::TransportHints hints("raw", no_delay, private_node_handle);
  if (hints.getTransport() != "compressed") {
    const auto take = [this](const sensor_msgs::ImageConstPtr& image) {
      add([this, image] { use_(image); });
    };
    subscriber_ = transport_.subscribe("image", size, take, ros::VoidPtr(), hints);
    return;
  }
  const boost::function<void(const sensor_msgs::CompressedImageConstPtr&)> take =
      [this](const sensor_msgs::CompressedImageConstPtr& compressed) {
        add([this, compressed] { takeCompressed(*compressed); });
      };
  compressed_subscriber_ =
      ros::NodeHandle(node_handle)
          .subscribe<sensor_msgs::CompressedImage>(node_handle.resolveName("image") + "/compressed",
                                                   size, take, ros::VoidConstPtr(), no_delay);
}

bool ImageInput::isSilent() const { return silence_.isSilent(ros::SteadyTime::now().toSec()); }

void ImageInput::takeCompressed(const sensor_msgs::CompressedImage& compressed) {
  sensor_msgs::ImageConstPtr image;
  try {
    image = decoded(compressed);
  } catch (const std::exception& error) {  // no memory for what its header promises
    return refuse_({"not decoded", error.what()});
  }
  if (image) return use_(image);
  refuse_({"not decoded", describeUndecoded(compressed)});
}

void ImageInput::add(const WaitingWork::Work& work) {
  silence_.saw(ros::SteadyTime::now().toSec());
  waiting_.add(work);
}

}  // namespace bearing_calibration_ros
