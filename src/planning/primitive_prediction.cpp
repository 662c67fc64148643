#include "bearing_calibration/planning/primitive_prediction.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/motion_model.h"

namespace bearing_calibration::core {
namespace {

constexpr double kLongestStep_s = 0.25;  // 0.4 rad of a spin at 0.2 m/s: information hardly varies
constexpr double kSameStep = 1e-9;       // of a part of the way: rounding

/// Takes in a bearing of this variance; the mean is as expected.
/// @param speeds  of the wheels meanwhile: what a late stamp moves the light by (eq. 16)
void see(double variance_rad2, const WheelSpeeds& speeds, double wheel_separation_m,
         StateEstimate* state) {
  const StateLayout& layout = state->layout;
  StateRow H = expectAzimuth(layout, state->mean, 0, {}).J_angle_state;
  if (layout.errors > placeOf<TimeOffset>()) {
    const Eigen::Vector2d light_mps =
        Eigen::Vector2d(0.5 * (speeds.left_mps + speeds.right_mps), 0.0) +
        (speeds.right_mps - speeds.left_mps) / wheel_separation_m *
            perpendicular(state->mean.tail<2>());
    H(kMountSize + placeOf<TimeOffset>()) = H.tail<2>().dot(light_mps.transpose());
  }
  apply(prepareUpdate(H, 0.0, variance_rad2, *state), state);
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

StateEstimate movedBy(const OdometryIncrement& motion, StateEstimate estimate) {
  propagate(motion, &estimate);
  return estimate;
}

StateEstimate predictAfter(const MotionPrimitive& primitive, const StateEstimate& estimate,
                           const WheelLimits& limits, const SensingModel& sensing) {
  StateEstimate predicted = estimate;
  const auto follow = [&](const WheelDisplacement& wheels) {
    const double duration_s = travelTime(wheels.right_m, limits);
    if (duration_s <= 0.0) return;
    const int steps = static_cast<int>(std::ceil(duration_s / kLongestStep_s));
    const double step_s = duration_s / steps;
    const double variance_rad2 = sensing.bearing_stddev_rad * sensing.bearing_stddev_rad /
                                 (step_s * sensing.bearing_rate_hz);
    double done = 0.0;
    double last_part = 0.0;
    OdometryIncrement motion;
    for (int i = 1; i <= steps; ++i) {
      const double share = travelAt(i * step_s, wheels.right_m, limits) / wheels.right_m;
      const double part = share - done;
      done = share;
      const WheelDisplacement rolled{part * wheels.left_m, part * wheels.right_m};
      if (std::abs(part - last_part) > kSameStep) {  // at full speed one step is like the last
        motion = append({}, rolled, limits.wheel_separation_m, sensing.wheel_noise, 0.0);
        last_part = part;
      }
      propagate(motion, &predicted);
      see(variance_rad2, {rolled.left_m / step_s, rolled.right_m / step_s},
          limits.wheel_separation_m, &predicted);
    }
  };
  follow(turningWheels(primitive, limits.wheel_separation_m));
  follow(straightWheels(primitive));
  return predicted;
}

double lightClearance(const MotionPrimitive& primitive, const CartesianEstimate& estimate,
                      double sigmas) {
  const Eigen::Vector2d light = estimate.lightInBase();
  const Eigen::Vector2d course(std::cos(primitive.turn_rad), std::sin(primitive.turn_rad));
  const double nearest_m = std::clamp(course.dot(light), std::min(0.0, primitive.length_m),
                                      std::max(0.0, primitive.length_m));
  const Eigen::Vector2d to_light = light - nearest_m * course;
  const double distance_m = to_light.norm();
  if (distance_m <= 0.0) return 0.0;
  const Eigen::Vector2d direction = to_light / distance_m;
  const Eigen::Matrix2d covariance = estimate.covariance.topLeftCorner<2, 2>();
  return distance_m - sigmas * std::sqrt(direction.dot(covariance * direction));
}

}  // namespace bearing_calibration::core
