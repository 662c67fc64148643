#include "bearing_calibration/odometry/odometry_increment.h"

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

Eigen::Matrix2d wheelCovariance(const WheelDisplacement& wheels, const WheelNoise& noise) {
  const double left = std::abs(wheels.left_m);
  const double right = std::abs(wheels.right_m);
  Eigen::Matrix2d covariance =
      Eigen::Matrix2d::Constant(noise.common_k_m * 0.5 * std::abs(wheels.left_m + wheels.right_m));
  covariance(0, 0) += noise.independent_k_m * left;
  covariance(1, 1) += noise.independent_k_m * right;
  return covariance;
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
  const Pose2Composition sum = compose(first.start_from_end, second.start_from_end);
  OdometryIncrement result;
  result.start_from_end = sum.a_from_c;
  result.covariance = sum.J_ac_ab * first.covariance * sum.J_ac_ab.transpose() +
                      sum.J_ac_bc * second.covariance * sum.J_ac_bc.transpose();
  result.J_pose_wheels = sum.J_ac_ab * first.J_pose_wheels + sum.J_ac_bc * second.J_pose_wheels;
  result.distance_m = first.distance_m + second.distance_m;
  result.rotation_rad = first.rotation_rad + second.rotation_rad;
  return result;
}

}  // namespace bearing_calibration::core
