#include "bearing_calibration_ros/camera_rays.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/rig_checks.h"

namespace bearing_calibration_ros {
namespace {

using core::formatted;

struct DistortionModel {
  core::Lens lens = core::Lens::kPerspective;
  std::set<std::size_t> coefficients;  ///< how many it may have
};

/// By their names in sensor_msgs/distortion_models.h.
const std::map<std::string, DistortionModel>& distortionModels() {
  static const std::map<std::string, DistortionModel> kModels = {
      {"plumb_bob", {core::Lens::kPerspective, {0, 4, 5}}},
      {"rational_polynomial", {core::Lens::kPerspective, {0, 8}}},
      {"equidistant", {core::Lens::kFisheye, {0, 4}}},
      {"", {core::Lens::kPerspective, {0}}},  // a simulated camera's, without distortion
  };
  return kModels;
}

/// Without zeros behind those that the model has: OpenCV knows fourteen, and a driver may send all.
std::vector<double> coefficientsOf(const sensor_msgs::CameraInfo& info,
                                   const DistortionModel& model) {
  std::vector<double> coefficients = info.D;
  while (coefficients.size() > *model.coefficients.rbegin() && coefficients.back() == 0.0) {
    coefficients.pop_back();
  }
  return coefficients;
}

}  // namespace

std::optional<Refusal> refusalOf(const sensor_msgs::CameraInfo& info) {
  const auto model = distortionModels().find(info.distortion_model);
  if (model == distortionModels().end()) {
    return Refusal{"distortion_model", "its distortion_model '" + info.distortion_model +
                                           "' is none of plumb_bob, rational_polynomial, "
                                           "equidistant"};
  }
  if (model->second.coefficients.count(coefficientsOf(info, model->second).size()) == 0) {
    return Refusal{"distortion coefficients",
                   formatted("its distortion_model '%s' has no %zu D",
                             info.distortion_model.c_str(), info.D.size())};
  }
  const std::string fault = core::whyNoCamera(cameraFromMessage(info));
  return fault.empty() ? std::nullopt
                       : std::optional<Refusal>(Refusal{"uncalibrated camera", fault});
}

core::Camera cameraFromMessage(const sensor_msgs::CameraInfo& info) {
  const double binning_x = std::max(info.binning_x, 1U);  // 0 is the same as 1
  const double binning_y = std::max(info.binning_y, 1U);
  const DistortionModel& model = distortionModels().at(info.distortion_model);
  core::Camera camera;
  camera.lens = model.lens;
  camera.focal_u_px = info.K[0] / binning_x;
  camera.focal_v_px = info.K[4] / binning_y;
  // A binned pixel's centre lies between those of its parts.
  camera.centre_u_px = (info.K[2] - info.roi.x_offset + 0.5) / binning_x - 0.5;
  camera.centre_v_px = (info.K[5] - info.roi.y_offset + 0.5) / binning_y - 0.5;
  const std::vector<double> coefficients = coefficientsOf(info, model);
  std::copy(coefficients.begin(), coefficients.end(), camera.distortion.begin());
  return camera;
}

std::optional<Refusal> CameraRays::refusalOf(const sensor_msgs::Image& image) const {
  if (!info_)
    return Refusal{"no camera_info", "mirror/kind none needs it, but nothing came on " + topic_};
  if (auto refusal = bearing_calibration_ros::refusalOf(*info_)) {
    refusal->text = topic_ + ": " + refusal->text;
    return refusal;
  }
  const DeliveredImage delivered = deliveredImage(*info_);
  if (delivered.width_px != image.width || delivered.height_px != image.height) {
    return Refusal{"wrong imager", formatted("%s is for images of %ux%u", topic_.c_str(),
                                             delivered.width_px, delivered.height_px)};
  }
  if (auto refusal = places_.refusalOf(image.header)) return refusal;
  const std::string frame = withoutSlash(image.header.frame_id);
  if (frame == places_.sensorFrame()) {
    return Refusal{"frame of the image",
                   "its frame '" + frame +
                       "' has z ahead, frames/sensor has z up: name another one, and publish the "
                       "static transform; of a level camera: rosrun tf2_ros "
                       "static_transform_publisher 0 0 0 -1.5708 0 -1.5708 SENSOR " +
                       frame};
  }
  constexpr double kLargest_m = 1e-3;
  const double beside_m = places_.sensorFrom(frame).translation().head<2>().norm();
  if (beside_m <= kLargest_m) return std::nullopt;
  return Refusal{"lens beside frames/sensor",
                 formatted("its frame '%s' lies %.4f m beside frames/sensor '%s': a ray has no "
                           "distance, name a frame whose origin is the lens",
                           frame.c_str(), beside_m, places_.sensorFrame().c_str())};
}

core::Camera CameraRays::of(const sensor_msgs::Image& image) const {
  core::Camera camera = cameraFromMessage(*info_);
  camera.sensor_from_optical = places_.sensorFrom(image.header.frame_id).linear();
  return camera;
}

}  // namespace bearing_calibration_ros
