#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/distortion_models.h>

#include <boost/make_shared.hpp>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

/// A rendered image (the sensor's values) as the camera's driver would deliver it, without stamp
/// and frame.
inline sensor_msgs::ImagePtr messageFromRendered(const cv::Mat& values,
                                                 const core::ImageEncoding& encoding) {
  const std::string& name = core::layoutNames()[static_cast<std::size_t>(encoding.layout)];
  return imageMessage({}, name, core::encode(values, encoding));
}

/// The lens alone: the mirror in front of it has no place in this message.
inline sensor_msgs::CameraInfo infoOf(const core::CameraRig& rig, const std::string& frame) {
  sensor_msgs::CameraInfo info;
  info.header.frame_id = frame;
  info.width = static_cast<std::uint32_t>(rig.width_px);
  info.height = static_cast<std::uint32_t>(rig.height_px);
  info.distortion_model = sensor_msgs::distortion_models::PLUMB_BOB;
  constexpr std::size_t kPlumbBobCoefficients = 5;
  info.D.assign(kPlumbBobCoefficients, 0.0);
  const double focal_px = rig.pixelsPerSlope();
  const double u = rig.centre_px.x();
  const double v = rig.centre_px.y();
  info.K = {focal_px, 0.0, u, 0.0, focal_px, v, 0.0, 0.0, 1.0};
  info.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  info.P = {focal_px, 0.0, u, 0.0, 0.0, focal_px, v, 0.0, 0.0, 0.0, 1.0, 0.0};
  return info;
}

/// What the camera is to photograph.
struct Shot {
  core::Stamp stamp;         ///< of the message
  std::uint64_t number = 0;  ///< decides the noise
  core::SensorMotion motion;
  bool lights_occluded = false;
};

/// Renders and publishes camera/image_raw and camera/camera_info.
///
/// Threading: images are rendered on a thread of their own, so that no wheel reading waits for one.
/// take() may be called from one other thread; the two share the queue alone, under its lock.
class SimulatedCamera {
 public:
  using ErrorLog = std::function<void(const std::string&)>;

  /// @throws std::invalid_argument for a wrong renderer.
  SimulatedCamera(const ros::NodeHandle& node_handle, const std::string& frame,
                  const core::RendererConfig& config, const core::Scene& scene, ErrorLog log_error)
      : renderer_(config, scene.surroundings),
        lights_(scene.lights),
        camera_info_(infoOf(config.rig, frame)),
        publisher_(image_transport::ImageTransport(node_handle)
                       .advertiseCamera("camera/image_raw", kPublisherQueue)),
        log_error_(std::move(log_error)),
        thread_(&SimulatedCamera::run, this) {}
  ~SimulatedCamera() {
    stop();
    thread_.join();
  }
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  enum class WhenBusy : std::uint8_t { kWait, kDrop };
  /// Queues a shot. False when it was dropped because the renderer cannot follow.
  bool take(const Shot& shot, WhenBusy when_busy) {
    std::unique_lock<std::mutex> lock(mutex_);
    const auto has_room = [this] { return waiting_.size() < kMostWaiting; };
    if (when_busy == WhenBusy::kWait) {
      changed_.wait(lock, [&] { return is_stopped_ || has_room(); });
    }
    if (is_stopped_ || !has_room()) return false;
    waiting_.push_back(shot);
    changed_.notify_all();
    return true;
  }
  /// Ends the thread after the image in work; take() no longer waits.
  void stop() {
    const std::lock_guard<std::mutex> lock(mutex_);
    is_stopped_ = true;
    changed_.notify_all();
  }

 private:
  void run() {
    while (const auto shot = nextShot()) {
      const std::string error = thrownBy([&] { publish(*shot); });
      if (!error.empty()) log_error_(error);
    }
  }

  /// None when stopped.
  std::optional<Shot> nextShot() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return is_stopped_ || !waiting_.empty(); });
    if (is_stopped_) return std::nullopt;
    const Shot shot = waiting_.front();
    waiting_.pop_front();
    changed_.notify_all();
    return shot;
  }

  void publish(const Shot& shot) {
    if (publisher_.getNumSubscribers() == 0) return;  // nobody looks
    static const std::vector<core::Light> kDarkness;
    const cv::Mat rendered =
        renderer_.render(shot.lights_occluded ? kDarkness : lights_, shot.motion, shot.number);
    const sensor_msgs::ImagePtr image = messageFromRendered(rendered, renderer_.config().encoding);
    const auto info = boost::make_shared<sensor_msgs::CameraInfo>(camera_info_);
    image->header.frame_id = camera_info_.header.frame_id;
    image->header.stamp = rosFromStamp(shot.stamp);
    info->header = image->header;
    publisher_.publish(image, info);
  }

  static constexpr std::size_t kMostWaiting = 2;        ///< one in work, two behind it
  static constexpr std::uint32_t kPublisherQueue = 10;  ///< a second of images

  core::ImageRenderer renderer_;
  const std::vector<core::Light> lights_;
  sensor_msgs::CameraInfo camera_info_;
  image_transport::CameraPublisher publisher_;
  ErrorLog log_error_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Shot> waiting_;  ///< under mutex_
  bool is_stopped_ = false;   ///< under mutex_
  std::thread thread_;        ///< last, so that everything else is there before it runs
};

}  // namespace bearing_calibration_ros
