#include "bearing_calibration_ros/display_publisher.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

constexpr double kRate_hz = 10.0;  // smooth to the eye, and little beside the images
constexpr double kSigmas = 3.0;    // of ellipses and bands
constexpr bool kLatched = true;

/// "CONVERGING", and below it how well the mount is known.
std::string stateText(const core::CalibrationResult& result) {
  const std::string state = core::nameOf(result.state);
  if (!result.base_from_sensor) return state;
  const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
  char sigmas[80];
  std::snprintf(sigmas, sizeof(sigmas), "\nx +- %.1f  y +- %.1f mm  yaw +- %.2f deg",
                1e3 * stddev.x(), 1e3 * stddev.y(), core::degreesFromRadians(stddev.z()));
  return state + sigmas;
}

}  // namespace

DisplayPublisher::DisplayPublisher(ros::NodeHandle private_node_handle,
                                   const CalibrationNodeConfig& config)
    : style_(visualisationStyleFrom(config)),
      visualiser_(kSigmas),
      publisher_(
          private_node_handle.advertise<visualization_msgs::MarkerArray>("markers", 1, kLatched)) {}

void DisplayPublisher::offer(const core::Calibrator& calibrator) {
  const ros::SteadyTime now = ros::SteadyTime::now();
  if ((now - last_drawn_).toSec() * kRate_hz < 1.0) return;
  last_drawn_ = now;
  const core::CalibrationResult result = calibrator.result();
  const auto place = calibrator.place();
  const core::Visualisation visualisation =
      visualiser_.draw(result, place ? place->start_from_base : core::Pose2{});
  if (publisher_.getNumSubscribers() == 0) return;
  if (place) sendStart(*place);
  publisher_.publish(markersFromVisualisation(visualisation, stateText(result), style_));
}

void DisplayPublisher::sendStart(const core::BasePlace& place) {
  // The last place holds while the wheels are silent. It is sent again for those who come late, but
  // a stamp is never sent twice.
  constexpr core::Duration kLater = std::chrono::milliseconds(1);
  last_sent_ = std::max(place.stamp, last_sent_ + kLater);
  if (!tf_broadcaster_) tf_broadcaster_ = std::make_unique<tf2_ros::TransformBroadcaster>();
  tf_broadcaster_->sendTransform(transformFromPlane(place.start_from_base.inverse(), last_sent_,
                                                    style_.base_frame, style_.start_frame));
}

void DisplayPublisher::restart() {
  visualiser_.restart();
  last_sent_ = {};
}

}  // namespace bearing_calibration_ros
