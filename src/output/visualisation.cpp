#include "bearing_calibration/output/visualisation.h"

#include <cmath>

#include "bearing_calibration/geometry/pictures.h"

namespace bearing_calibration::core {
namespace {

constexpr double kPathSpacing_m = 0.02;    // fine enough for the eye, and no growth while it stands
constexpr std::size_t kPathPoints = 2000;  // more than a screen has pixels
constexpr int kEllipseSegments = 64;       // looks round
constexpr double kRayPart = 1.1;           // of the light's distance: one sees where it passes by

/// From the sensor in the direction of the bearing, by the mount and the pose of that moment.
std::array<Eigen::Vector2d, 2> rayOf(double azimuth_rad, const CartesianEstimate& estimate,
                                     const Pose2& start_from_base) {
  const Pose2 base_from_sensor{estimate.sensorInBase(), estimate.sensorYaw()};
  const Pose2 start_from_sensor = start_from_base * base_from_sensor;
  const double length_m = kRayPart * estimate.range();
  const Eigen::Vector2d along(length_m * std::cos(azimuth_rad), length_m * std::sin(azimuth_rad));
  return {start_from_sensor.position_m, start_from_sensor * along};
}

}  // namespace

Visualiser::Visualiser(double sigmas) : sigmas_(sigmas), path_(kPathSpacing_m, kPathPoints) {}

void Visualiser::see(const AssociationOutcome& outcome) {
  if (outcome.kind == Association::Kind::kFound) last_fused_ = outcome.observation;
}

Visualisation Visualiser::draw(const CalibrationResult& result, const Pose2& start_from_base_now) {
  path_.add(start_from_base_now.position_m);
  Visualisation visualisation;
  visualisation.path_in_start = path_.points_m();
  if (!result.cartesian_state) return visualisation;
  visualisation.found = drawFound(result);
  if (last_fused_ && last_fused_->stamp == result.stamp) {
    ray_in_start_ =
        rayOf(last_fused_->azimuth_rad, *result.cartesian_state, result.start_from_base);
  }
  visualisation.ray_in_start = ray_in_start_;
  return visualisation;
}

Visualisation::Light Visualiser::drawLight(const CartesianEstimate& estimate,
                                           const Pose2& start_from_base, bool in_estimate) const {
  const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
  Visualisation::Light light{
      start_from_base * estimate.lightInBase(),
      ellipseOutline(covariance, sigmas_, estimate.lightInBase(), kEllipseSegments), in_estimate};
  for (Eigen::Vector2d& point : light.ellipse_in_start) point = start_from_base * point;
  return light;
}

Visualisation::Found Visualiser::drawFound(const CalibrationResult& result) const {
  const CartesianEstimate& estimate = *result.cartesian_state;
  constexpr int kSensor = CartesianIndex::kSensorX;
  constexpr int kYaw = CartesianIndex::kSensorYaw;
  Visualisation::Found found;
  found.base_from_sensor = {estimate.sensorInBase(), estimate.sensorYaw()};
  found.sensor_ellipse_in_base = ellipseOutline(estimate.covariance.block<2, 2>(kSensor, kSensor),
                                                sigmas_, estimate.sensorInBase(), kEllipseSegments);
  found.sensor_yaw_band_rad = sigmas_ * std::sqrt(estimate.covariance(kYaw, kYaw));
  found.lights = {drawLight(estimate, result.start_from_base, true)};
  for (const LightSummary& light : result.lights) {
    const auto& state = light.cartesian_state;
    if (!state || state->lightInBase() == estimate.lightInBase()) continue;
    found.lights.push_back(drawLight(*state, result.start_from_base, light.in_estimate));
  }
  return found;
}

void Visualiser::restart() {
  path_.clear();
  last_fused_.reset();
  ray_in_start_.reset();
}

}  // namespace bearing_calibration::core
