#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// A rendered image (the sensor's values) as the camera's driver would deliver it, without stamp
/// and frame.
sensor_msgs::ImagePtr messageFromRendered(const cv::Mat& values,
                                          const core::ImageEncoding& encoding);

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
                  const core::RendererConfig& config, const core::Scene& scene, ErrorLog log_error);
  ~SimulatedCamera();
  SimulatedCamera(const SimulatedCamera&) = delete;
  SimulatedCamera& operator=(const SimulatedCamera&) = delete;

  enum class WhenBusy : std::uint8_t { kWait, kDrop };
  /// Queues a shot. False when it was dropped because the renderer cannot follow.
  bool take(const Shot& shot, WhenBusy when_busy);
  /// Ends the thread after the image in work; take() no longer waits.
  void stop();

 private:
  void run();
  bool nextShot(Shot* shot);
  void publish(const Shot& shot);

  static constexpr std::size_t kMostWaiting = 2;  ///< one in work, two behind it

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
