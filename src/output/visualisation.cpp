#include "bearing_calibration/output/visualisation.h"

#include <cmath>

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
  const double length_m = kRayPart * (estimate.lightInBase() - estimate.sensorInBase()).norm();
  const Eigen::Vector2d along(length_m * std::cos(azimuth_rad), length_m * std::sin(azimuth_rad));
  return {start_from_sensor.position_m, start_from_sensor * along};
}

}  // namespace

Visualiser::Visualiser(double sigmas) : sigmas_(sigmas), path_(kPathSpacing_m, kPathPoints) {}

void Visualiser::see(const AssociationOutcome& outcome) {
  if (outcome.kind == AssociationOutcome::Kind::kTaken) last_fused_ = outcome.observation;
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

std::vector<Eigen::Vector2d> Visualiser::ellipseInStart(const CartesianEstimate& estimate,
                                                        const Pose2& start_from_base) const {
  const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
  std::vector<Eigen::Vector2d> ellipse =
      ellipseOutline(covariance, sigmas_, estimate.lightInBase(), kEllipseSegments);
  for (Eigen::Vector2d& point : ellipse) point = start_from_base * point;
  return ellipse;
}

Visualisation::Found Visualiser::drawFound(const CalibrationResult& result) const {
  const CartesianEstimate& estimate = *result.cartesian_state;
  const Eigen::Matrix2d sensor_covariance =
      estimate.covariance.block<2, 2>(CartesianIndex::kSensorX, CartesianIndex::kSensorX);
  const double yaw_variance =
      estimate.covariance(CartesianIndex::kSensorYaw, CartesianIndex::kSensorYaw);
  Visualisation::Found found;
  found.base_from_sensor = {estimate.sensorInBase(), estimate.sensorYaw()};
  found.sensor_ellipse_in_base =
      ellipseOutline(sensor_covariance, sigmas_, estimate.sensorInBase(), kEllipseSegments);
  found.sensor_yaw_band_rad = sigmas_ * std::sqrt(yaw_variance);
  found.light_in_start = result.start_from_base * estimate.lightInBase();
  found.light_ellipse_in_start = ellipseInStart(estimate, result.start_from_base);
  for (const LightSummary& light : result.lights) {
    if (!light.cartesian_state) continue;
    const Eigen::Vector2d in_base = light.cartesian_state->lightInBase();
    if (in_base == estimate.lightInBase()) continue;
    found.further_lights.push_back({result.start_from_base * in_base,
                                    ellipseInStart(*light.cartesian_state, result.start_from_base),
                                    light.in_estimate});
  }
  return found;
}

void Visualiser::restart() {
  path_.clear();
  last_fused_.reset();
  ray_in_start_.reset();
}

}  // namespace bearing_calibration::core
