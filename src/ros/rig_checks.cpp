#include "bearing_calibration_ros/rig_checks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/optics/conic_mirror.h"
#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration_ros {

bool DeliveredImage::isOf(const core::ImageSensor& sensor) const {
  return width_px == static_cast<std::uint32_t>(sensor.width_px) &&
         height_px == static_cast<std::uint32_t>(sensor.height_px);
}

DeliveredImage deliveredImage(const sensor_msgs::CameraInfo& info) {
  const auto& region = info.roi;  // all zero: the whole imager
  const std::uint32_t width = region.width > 0 ? region.width : info.width;
  const std::uint32_t height = region.height > 0 ? region.height : info.height;
  const std::uint32_t binning_x = std::max(info.binning_x, 1U);  // 0 is the same as 1
  const std::uint32_t binning_y = std::max(info.binning_y, 1U);
  return {width / binning_x, height / binning_y, info.K[0] / binning_x};
}

std::string contradiction(const DeliveredImage& image, const core::DetectorConfig& detector) {
  const core::ImageSensor& sensor = detector.sensor;
  if (image.isSaid() && !image.isOf(sensor)) {
    return core::formatted(
        "it is for images of %ux%u, sensor/width and sensor/height of %dx%d: what is "
        "measured in one does not fit the other",
        image.width_px, image.height_px, sensor.width_px, sensor.height_px);
  }
  // Data sheets and refocusing leave some per cent; a binning that was forgotten is a factor of 2.
  constexpr double kLargestRatio = 1.25;
  const double configured_px = core::imageDistancePx(detector.mirror);
  const bool differs =
      image.focal_length_px > 0.0 &&
      std::abs(std::log(image.focal_length_px / configured_px)) > std::log(kLargestRatio);
  if (detector.mirror_kind != core::MirrorKind::kCone || !differs) return {};
  return core::formatted(
      "its focal length is %.0f px of the images as they come, that of lens/ %.0f px: does "
      "lens/pixel_pitch count the binning?",
      image.focal_length_px, configured_px);
}

msg::FindMirrorResponse noMirror(const std::string& why) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  msg::FindMirrorResponse response;
  response.centre_u = response.centre_v = response.radius = kNothing;
  response.centre_u_stddev = response.centre_v_stddev = response.radius_stddev = kNothing;
  response.text = why;
  return response;
}

msg::FindMirrorResponse findMirror(const cv::Mat& image, const core::DetectorConfig& config) {
  if (config.mirror_kind == core::MirrorKind::kNone) {
    return noMirror("mirror/kind is none: there is no mirror");
  }
  const bool knows_optics = config.mirror_kind == core::MirrorKind::kCone;
  const std::optional<core::MirrorRim> rim = core::findMirrorRim(
      image, knows_optics ? core::rimSearchAround(config) : core::rimSearchIn(image));
  if (!rim) {
    return noMirror(
        std::string("no rim ") +
        (knows_optics ? "within a quarter of the radius that lens and mirror predict" : "found") +
        ": is the mirror in the picture, and is there light beside it?");
  }
  const core::MirrorCheck check = core::checkMirror(*rim, config);
  msg::FindMirrorResponse response;
  response.found = true;
  response.centre_u = rim->circle.centre_px.x();
  response.centre_v = rim->circle.centre_px.y();
  response.radius = rim->circle.radius_px;
  response.centre_u_stddev = rim->stddev(0);
  response.centre_v_stddev = rim->stddev(1);
  response.radius_stddev = rim->stddev(2);
  response.consistent = check.consistent;
  response.text = core::joined(check.sentences, "; ");
  return response;
}

}  // namespace bearing_calibration_ros
