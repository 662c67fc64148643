#include "bearing_calibration/planning/hop_prediction.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration {
namespace {

constexpr double kLongestStep_s = 0.25;  // 0.4 rad of a spin at 0.2 m/s: information hardly varies

/// The covariance after a bearing of this variance; the plain form of eq. 8, which is enough for a
/// prediction over seconds.
void see(double variance_rad2, CartesianEstimate* estimate) {
  const Eigen::Matrix<double, 1, 5> H = azimuthFromCartesian(estimate->mean).J_azimuth_state;
  const Vector5 PHt = estimate->covariance * H.transpose();
  estimate->covariance -= PHt * PHt.transpose() / (H.dot(PHt) + variance_rad2);
}

}  // namespace

std::vector<std::string> SensingModel::validate() const {
  Requirements require;
  require.add(wheel_noise.validate());
  require.between("planner/bearing_stddev", bearing_stddev_rad, plausible::kLeastAngle_rad,
                  plausible::kTurn_rad);
  require.between("planner/bearing_rate", bearing_rate_hz, plausible::kRarest_hz,
                  plausible::kMostFrequent_hz);
  return require.errors();
}

CartesianEstimate movedBy(const OdometryIncrement& motion, const CartesianEstimate& estimate) {
  const Propagation step = propagateCartesian(estimate.mean, motion);
  // The mount stays as it is: only the light's rows and columns change.
  const Eigen::Matrix2d F = step.J_state_state.topLeftCorner<2, 2>();
  const Eigen::Matrix<double, 2, 3> G = step.J_state_motion.topRows<2>();
  CartesianEstimate moved{step.state, estimate.covariance};
  moved.covariance.topRows<2>() = F * estimate.covariance.topRows<2>();
  moved.covariance.leftCols<2>() = (moved.covariance.leftCols<2>() * F.transpose()).eval();
  moved.covariance.topLeftCorner<2, 2>() += G * motion.covariance * G.transpose();
  return moved;
}

CartesianEstimate predictAfter(const Hop& hop, const CartesianEstimate& estimate,
                               const WheelLimits& limits, const SensingModel& sensing) {
  CartesianEstimate predicted = estimate;
  const auto follow = [&](const WheelDisplacement& wheels) {
    const double duration_s = travelTime(wheels.right_m, limits);
    if (duration_s <= 0.0) return;
    const int steps = static_cast<int>(std::ceil(duration_s / kLongestStep_s));
    const double step_s = duration_s / steps;
    const double variance_rad2 = sensing.bearing_stddev_rad * sensing.bearing_stddev_rad /
                                 (step_s * sensing.bearing_rate_hz);
    double done = 0.0;
    for (int i = 1; i <= steps; ++i) {
      const double share = travelAt(i * step_s, wheels.right_m, limits) / wheels.right_m;
      const double part = share - done;
      done = share;
      predicted = movedBy(append({}, {part * wheels.left_m, part * wheels.right_m},
                                 limits.wheel_separation_m, sensing.wheel_noise, 0.0),
                          predicted);
      see(variance_rad2, &predicted);
    }
  };
  follow(turningWheels(hop, limits.wheel_separation_m));
  follow(straightWheels(hop));
  return predicted;
}

double lightClearance(const Hop& hop, const CartesianEstimate& estimate, double sigmas) {
  const Eigen::Vector2d light = estimate.lightInBase();
  const Eigen::Vector2d course(std::cos(hop.turn_rad), std::sin(hop.turn_rad));
  const double nearest_m =
      std::clamp(course.dot(light), std::min(0.0, hop.length_m), std::max(0.0, hop.length_m));
  const Eigen::Vector2d to_light = light - nearest_m * course;
  const double distance_m = to_light.norm();
  if (distance_m <= 0.0) return 0.0;
  const Eigen::Vector2d direction = to_light / distance_m;
  const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
  return distance_m - sigmas * std::sqrt(direction.dot(covariance * direction));
}

}  // namespace bearing_calibration
