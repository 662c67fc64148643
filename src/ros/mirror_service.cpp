#include "bearing_calibration_ros/mirror_service.h"

#include <limits>
#include <optional>
#include <string>

#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration_ros {

msg::FindMirrorResponse noMirror(const std::string& why) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  msg::FindMirrorResponse response;
  response.found = false;
  response.consistent = false;
  response.centre_u = response.centre_v = response.radius = kNothing;
  response.centre_u_stddev = response.centre_v_stddev = response.radius_stddev = kNothing;
  response.text = why;
  return response;
}

msg::FindMirrorResponse findMirror(const cv::Mat& image, const core::DetectorConfig& config) {
  const std::optional<core::MirrorRim> rim =
      core::findMirrorRim(image, core::rimSearchAround(config));
  if (!rim) {
    return noMirror(
        "no rim within a quarter of the radius that lens and mirror predict: is the mirror in the "
        "picture, and is there light beside it?");
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
  for (const std::string& sentence : check.sentences) {
    response.text += (response.text.empty() ? "" : "; ") + sentence;
  }
  return response;
}

}  // namespace bearing_calibration_ros
