#pragma once

#include <image_transport/exception.h>
#include <image_transport/image_transport.h>
#include <ros/callback_queue_interface.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <boost/make_shared.hpp>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <stdexcept>
#include <utility>

#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/input_watch.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// The work on messages that wait while one is worked on: of more than `most` the oldest is dropped
/// and counted, which a subscriber's own queue does not tell.
///
/// add() is called by callbacks of `queue`, which serves one at a time. The work is a callback of
/// its own, behind those that wait already: so by then all that has come meanwhile is here.
class WaitingWork {
 public:
  using Work = std::function<void()>;

  WaitingWork(ros::CallbackQueueInterface* queue, std::size_t most) : queue_(queue), most_(most) {}
  ~WaitingWork() { queue_->removeByID(id()); }
  WaitingWork(const WaitingWork&) = delete;
  WaitingWork& operator=(const WaitingWork&) = delete;

  void add(Work work) {
    waiting_.push_back(std::move(work));
    if (waiting_.size() <= most_) {
      queue_->addCallback(boost::make_shared<Turn>(this), id());
      return;
    }
    waiting_.pop_front();  // its turn is the next one's
    ++dropped_;
  }

  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Turn : ros::CallbackInterface {
    explicit Turn(WaitingWork* all) : all_(all) {}
    CallResult call() override {
      all_->doFirst();
      return Success;
    }
    WaitingWork* all_;
  };

  void doFirst() {
    const Work first = std::move(waiting_.front());
    waiting_.pop_front();
    first();
  }
  std::uint64_t id() const { return reinterpret_cast<std::uintptr_t>(this); }

  ros::CallbackQueueInterface* queue_;
  std::size_t most_;
  std::deque<Work> waiting_;
  std::uint64_t dropped_ = 0;
};

/// The images of the topic `image`, raw or of another transport (the private parameter
/// image_transport). Those that wait while one is worked on are few, and the newest. What is
/// compressed is decoded here: Debian has no plugin of image_transport for it.
///
/// Threading: all callbacks are those of the node handle's queue, which must serve one at a time.
class ImageInput {
 public:
  using Use = std::function<void(const sensor_msgs::ImageConstPtr&)>;
  using Refuse = std::function<void(const Refusal&)>;

  /// @param queue  images that may wait
  /// @param use    takes each image; throws nothing
  /// @param refuse says why one could not be decoded
  /// @throws std::runtime_error for a transport that is not known
  ImageInput(ros::NodeHandle node_handle, const ros::NodeHandle& private_node_handle, int queue,
             Use use, Refuse refuse)
      : use_(std::move(use)),
        refuse_(std::move(refuse)),
        waiting_(node_handle.getCallbackQueue(), static_cast<std::size_t>(queue)) {
    // What comes while one image is searched is taken over at once: what is late is dropped there.
    constexpr int kArrivingImages = 20;
    const auto size = static_cast<std::uint32_t>(queue + kArrivingImages);
    const ros::TransportHints no_delay = ros::TransportHints().tcpNoDelay();
    const image_transport::TransportHints hints("raw", no_delay, private_node_handle);
    if (hints.getTransport() == "compressed") {
      compressed_subscriber_ = node_handle.subscribe<sensor_msgs::CompressedImage>(
          node_handle.resolveName("image") + "/compressed", size,
          [this](const sensor_msgs::CompressedImageConstPtr& compressed) {
            add([this, compressed] { takeCompressed(*compressed); });
          },
          {}, no_delay);
      return;
    }
    const auto take = [this](const sensor_msgs::ImageConstPtr& image) {
      add([this, image] { use_(image); });
    };
    try {
      subscriber_ = image_transport::ImageTransport(node_handle)
                        .subscribe("image", size, take, ros::VoidPtr(), hints);
    } catch (const image_transport::Exception& error) {
      throw std::runtime_error(
          "image_transport must be raw, compressed or of an installed plugin, but is '" +
          hints.getTransport() + "': " + error.what());
    }
  }

  /// Images for which newer ones had come before their turn.
  std::uint64_t dropped() const { return waiting_.dropped(); }
  bool isSilent() const { return silence_.isSilent(ros::SteadyTime::now().toSec()); }

 private:
  void takeCompressed(const sensor_msgs::CompressedImage& compressed) {
    sensor_msgs::ImageConstPtr image;
    // There may be no memory for what its header promises.
    const std::string error = thrownBy([&] { image = decoded(compressed); });
    if (image) return use_(image);
    refuse_({"not decoded", error.empty() ? describeUndecoded(compressed) : error});
  }

  void add(const WaitingWork::Work& work) {
    silence_.saw(ros::SteadyTime::now().toSec());
    waiting_.add(work);
  }

  Use use_;
  Refuse refuse_;
  SilenceWatch silence_;
  WaitingWork waiting_;
  image_transport::Subscriber subscriber_;  ///< the last ones: their callbacks use the others
  ros::Subscriber compressed_subscriber_;
};

}  // namespace bearing_calibration_ros
