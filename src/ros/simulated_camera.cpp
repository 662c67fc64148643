#include "bearing_calibration_ros/simulated_camera.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/distortion_models.h>

#include <boost/make_shared.hpp>
#include <utility>

#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {
namespace {

/// The lens alone: the mirror in front of it has no place in this message.
sensor_msgs::CameraInfo infoOf(const core::CameraRig& rig, const std::string& frame) {
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

}  // namespace

sensor_msgs::ImagePtr messageFromRendered(const cv::Mat& values,
                                          const core::ImageEncoding& encoding) {
  const std::string& name = core::layoutNames()[static_cast<std::size_t>(encoding.layout)];
  return cv_bridge::CvImage({}, name, core::encode(values, encoding)).toImageMsg();
}

SimulatedCamera::SimulatedCamera(const ros::NodeHandle& node_handle, const std::string& frame,
                                 const core::RendererConfig& config, const core::Scene& scene,
                                 ErrorLog log_error)
    : renderer_(config, scene.surroundings),
      lights_(scene.lights),
      camera_info_(infoOf(config.rig, frame)),
      log_error_(std::move(log_error)) {
  constexpr std::uint32_t kQueue = 10;  // a second of images
  publisher_ =
      image_transport::ImageTransport(node_handle).advertiseCamera("camera/image_raw", kQueue);
  thread_ = std::thread(&SimulatedCamera::run, this);
}

SimulatedCamera::~SimulatedCamera() {
  stop();
  thread_.join();
}

void SimulatedCamera::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}

bool SimulatedCamera::take(const Shot& shot, WhenBusy when_busy) {
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

bool SimulatedCamera::nextShot(Shot* shot) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return is_stopped_ || !waiting_.empty(); });
  if (is_stopped_) return false;
  *shot = waiting_.front();
  waiting_.pop_front();
  changed_.notify_all();
  return true;
}

void SimulatedCamera::run() {
  Shot shot;
  while (nextShot(&shot)) {
    const std::string error = thrownBy([&] { publish(shot); });
    if (!error.empty()) log_error_(error);
  }
}

void SimulatedCamera::publish(const Shot& shot) {
  if (publisher_.getNumSubscribers() == 0) return;  // nobody looks
  static const std::vector<core::Light> kDarkness;
  const core::ImageEncoding& encoding = renderer_.config().encoding;
  const cv::Mat rendered =
      renderer_.render(shot.lights_occluded ? kDarkness : lights_, shot.motion, shot.number);
  const sensor_msgs::ImagePtr image = messageFromRendered(rendered, encoding);
  const auto info = boost::make_shared<sensor_msgs::CameraInfo>(camera_info_);
  image->header.frame_id = camera_info_.header.frame_id;
  image->header.stamp = rosFromStamp(shot.stamp);
  info->header = image->header;
  publisher_.publish(image, info);
}

}  // namespace bearing_calibration_ros
