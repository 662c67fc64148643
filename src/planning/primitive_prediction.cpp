#include "bearing_calibration/planning/primitive_prediction.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {
namespace {

constexpr double kLongestStep_s = 0.25;  // 0.4 rad of a spin at 0.2 m/s: information hardly varies
constexpr double kSameStep = 1e-9;       // of a part of the way: rounding

template <int K>
Gaussian<5 + K> moved(const OdometryIncrement& measured, const Gaussian<5 + K>& state) {
  ErrorVector errors = ErrorVector::Zero();
  errors.head<K>() = state.mean.template tail<K>();
  const CorrectedMotion<K> corrected = correctMotion<K>(measured, errors);
  OdometryIncrement motion = measured;
  motion.start_from_end = corrected.start_from_end;
  const Propagation step = propagateCartesian(state.mean.template head<5>(), motion);
  const Eigen::Matrix<double, 2, 3> J_light_motion = step.J_state_motion.topRows<2>();
  Gaussian<5 + K> next = state;
  next.mean.template head<5>() = step.state;
  propagateCovariance<K>(
      step.J_state_state.topLeftCorner<2, 2>(), J_light_motion * corrected.J_pose_errors,
      J_light_motion * motion.covariance * J_light_motion.transpose(), next.covariance);
  return next;
}

/// The covariance after a bearing of this variance; the plain form of eq. 8, which is enough for a
/// prediction over seconds.
/// @param speeds  of the wheels meanwhile: what a late stamp moves the light by (eq. 16)
template <int K>
void see(double variance_rad2, const WheelSpeeds& speeds, double wheel_separation_m,
         Gaussian<5 + K>* state) {
  const Vector5 cartesian = state->mean.template head<5>();
  Eigen::Matrix<double, 1, 5 + K> H = Eigen::Matrix<double, 1, 5 + K>::Zero();
  H.template head<5>() = azimuthFromCartesian(cartesian).J_azimuth_state;
  if constexpr (K > 0) {
    const Eigen::Vector2d light_mps =
        Eigen::Vector2d(0.5 * (speeds.left_mps + speeds.right_mps), 0.0) +
        (speeds.right_mps - speeds.left_mps) / wheel_separation_m *
            perpendicular(cartesian.head<2>());
    H(5 + placeOf<TimeOffset>()) = H.template head<2>() * light_mps;
  }
  const Eigen::Matrix<double, 5 + K, 1> PHt = state->covariance * H.transpose();
  const Eigen::Matrix<double, 5 + K, 1> gain = PHt / (H.dot(PHt) + variance_rad2);
  state->covariance -= gain * PHt.transpose();
}

template <int K>
Gaussian<5 + K> after(const MotionPrimitive& primitive, const Gaussian<5 + K>& start,
                      const WheelLimits& limits, const SensingModel& sensing) {
  Gaussian<5 + K> predicted = start;
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
      predicted = moved<K>(motion, predicted);
      see<K>(variance_rad2, {rolled.left_m / step_s, rolled.right_m / step_s},
             limits.wheel_separation_m, &predicted);
    }
  };
  follow(turningWheels(primitive, limits.wheel_separation_m));
  follow(straightWheels(primitive));
  return predicted;
}

/// Calls `work` with the number of errors that the estimate doubts, of clock and wheels or none.
template <class Work>
auto withDoubts(const RobotEstimate& estimate, Work work) {
  const bool doubts =
      !estimate.errors.covariance.topLeftCorner<kWheelErrors, kWheelErrors>().isZero(0.0);
  return withErrorsInUse(doubts ? kWheelErrors : 0, work);
}

}  // namespace

void SensingModel::declare(Parameters& params) {
  wheel_noise.declare(params);
  params.number("planner/bearing_stddev", bearing_stddev_rad, plausible::kLeastAngle_rad,
                plausible::kTurn_rad);
  params.number("planner/bearing_rate", bearing_rate_hz, plausible::kRarest_hz,
                plausible::kMostFrequent_hz);
}

RobotEstimate movedBy(const OdometryIncrement& motion, const RobotEstimate& estimate) {
  return withDoubts(estimate, [&](auto size) {
    constexpr int kErrors = size.value;
    return RobotEstimate::from<kErrors>(moved<kErrors>(motion, estimate.joint<kErrors>()));
  });
}

RobotEstimate predictAfter(const MotionPrimitive& primitive, const RobotEstimate& estimate,
                           const WheelLimits& limits, const SensingModel& sensing) {
  return withDoubts(estimate, [&](auto size) {
    constexpr int kErrors = size.value;
    return RobotEstimate::from<kErrors>(
        after<kErrors>(primitive, estimate.joint<kErrors>(), limits, sensing));
  });
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
