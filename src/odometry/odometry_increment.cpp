#include "bearing_calibration/odometry/odometry_increment.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {
namespace {

/// sin(x)/x and its derivative, by their series where the quotient would lose digits.
struct Sinc {
  double value;
  double derivative;
};

Sinc sinc(double x) {
  constexpr double kSeriesBelow = 1e-4;  // the series' next terms, x^4/120 and x^3/30, are < 1e-13
  if (std::abs(x) < kSeriesBelow) return {1.0 - x * x / 6.0, -x / 3.0};
  return {std::sin(x) / x, (std::cos(x) - std::sin(x) / x) / x};
}

/// Covariance of (left_m, right_m) of one displacement (model.md, eq. 3).
Eigen::Matrix2d wheelCovariance(const WheelDisplacement& wheels, const WheelNoise& noise) {
  Eigen::Matrix2d covariance =
      Eigen::Matrix2d::Constant(noise.common_k_m * 0.5 * std::abs(wheels.left_m + wheels.right_m));
  covariance(0, 0) += noise.independent_k_m * std::abs(wheels.left_m);
  covariance(1, 1) += noise.independent_k_m * std::abs(wheels.right_m);
  return covariance;
}

}  // namespace

Arc arcFromWheels(const WheelDisplacement& wheels, double wheel_separation_m) {
  const double distance = 0.5 * (wheels.right_m + wheels.left_m);
  const double turn = (wheels.right_m - wheels.left_m) / wheel_separation_m;
  const Sinc chord = sinc(0.5 * turn);  // chord length over arc length
  const Eigen::Vector2d direction(std::cos(0.5 * turn), std::sin(0.5 * turn));

  Eigen::Matrix<double, 3, 2> J_pose_motion;  // by (distance, turn)
  J_pose_motion.col(0) << chord.value * direction, 0.0;
  J_pose_motion.col(1) << 0.5 * distance *
                              (chord.derivative * direction +
                               chord.value * perpendicular(direction)),
      1.0;
  Eigen::Matrix2d J_motion_wheels;
  J_motion_wheels << 0.5, 0.5, -1.0 / wheel_separation_m, 1.0 / wheel_separation_m;
  return {{distance * chord.value * direction, wrapAngle(turn)}, J_pose_motion * J_motion_wheels};
}

WheelDisplacement wheelsFromArc(const Pose2& start_from_end, double wheel_separation_m) {
  const double half_turn = 0.5 * start_from_end.yaw_rad;
  const Eigen::Vector2d direction(std::cos(half_turn), std::sin(half_turn));
  const double distance = direction.dot(start_from_end.position_m) / sinc(half_turn).value;
  return {distance - wheel_separation_m * half_turn, distance + wheel_separation_m * half_turn};
}

OdometryIncrement append(const OdometryIncrement& increment, const WheelDisplacement& wheels,
                         double wheel_separation_m, const WheelNoise& noise,
                         double unseen_variance_m2) {
  const Arc arc = arcFromWheels(wheels, wheel_separation_m);
  const Eigen::Matrix2d wheel_covariance =
      wheelCovariance(wheels, noise) + unseen_variance_m2 * Eigen::Matrix2d::Identity();
  OdometryIncrement step;
  step.start_from_end = arc.start_from_end;
  step.covariance = arc.J_pose_wheels * wheel_covariance * arc.J_pose_wheels.transpose();
  step.has_unseen = unseen_variance_m2 > 0.0;
  step.distance_m = 0.5 * std::abs(wheels.left_m + wheels.right_m);
  step.rotation_rad = std::abs(wheels.right_m - wheels.left_m) / wheel_separation_m;
  step.J_pose_wheels.col(0) = arc.J_pose_wheels.col(0) * wheels.left_m;
  step.J_pose_wheels.col(1) = arc.J_pose_wheels.col(1) * wheels.right_m;
  // All three lengths stretched alike stretch the arc: that is their sum.
  step.J_pose_wheels.col(2) << arc.start_from_end.position_m, 0.0;
  step.J_pose_wheels.col(2) -= step.J_pose_wheels.col(0) + step.J_pose_wheels.col(1);
  return append(increment, step);
}

OdometryIncrement append(const OdometryIncrement& first, const OdometryIncrement& second) {
  const Eigen::Matrix2d R_first = rotation2(first.start_from_end.yaw_rad);
  Eigen::Matrix3d J_sum_first = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d J_sum_second = Eigen::Matrix3d::Identity();
  J_sum_first.topRightCorner<2, 1>() = perpendicular(R_first * second.start_from_end.position_m);
  J_sum_second.topLeftCorner<2, 2>() = R_first;
  OdometryIncrement result;
  result.start_from_end = first.start_from_end * second.start_from_end;
  result.covariance = J_sum_first * first.covariance * J_sum_first.transpose() +
                      J_sum_second * second.covariance * J_sum_second.transpose();
  result.J_pose_wheels = J_sum_first * first.J_pose_wheels + J_sum_second * second.J_pose_wheels;
  result.has_unseen = first.has_unseen || second.has_unseen;
  result.distance_m = first.distance_m + second.distance_m;
  result.rotation_rad = first.rotation_rad + second.rotation_rad;
  return result;
}

OdometryWindow::OdometryWindow(const std::array<WheelDisplacement, kSamples>& samples,
                               double wheel_separation_m)
    : samples_(samples), wheel_separation_m_(wheel_separation_m) {
  const WheelDisplacement zero = samples_[kBefore];
  for (WheelDisplacement& sample : samples_) {
    sample.left_m -= zero.left_m;
    sample.right_m -= zero.right_m;
  }
}

OdometryWindow OdometryWindow::withOtherWheels(const Eigen::Matrix2d& wheels_from_wheels,
                                               double wheel_separation_m) const {
  OdometryWindow changed = *this;
  changed.wheel_separation_m_ = wheel_separation_m;
  for (WheelDisplacement& sample : changed.samples_) {
    const Eigen::Vector2d wheels =
        wheels_from_wheels * Eigen::Vector2d(sample.left_m, sample.right_m);
    sample = {wheels.x(), wheels.y()};
  }
  return changed;
}

std::size_t OdometryWindow::intervalAt(double time_s) {
  const double steps = std::floor(time_s / kStep_s) + kBefore;
  constexpr double kLast = kSamples - 2;
  return static_cast<std::size_t>(std::min(std::max(0.0, steps), kLast));  // 0 for NaN, too
}

WheelDisplacement OdometryWindow::travelTo(double time_s) const {
  const std::size_t i = intervalAt(time_s);
  const WheelSpeeds speeds = speedsAt(time_s);
  const double since_s = time_s - (static_cast<double>(i) - kBefore) * kStep_s;
  return {samples_[i].left_m + speeds.left_mps * since_s,
          samples_[i].right_m + speeds.right_mps * since_s};
}

WheelSpeeds OdometryWindow::speedsAt(double time_s) const {
  const std::size_t i = intervalAt(time_s);
  return {(samples_[i + 1].left_m - samples_[i].left_m) / kStep_s,
          (samples_[i + 1].right_m - samples_[i].right_m) / kStep_s};
}

}  // namespace bearing_calibration::core
