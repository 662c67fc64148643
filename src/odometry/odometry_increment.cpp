#include "bearing_calibration/odometry/odometry_increment.h"

#include <cmath>

namespace bearing_calibration {
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
                         double wheel_separation_m, const WheelNoise& noise) {
  const Arc arc = arcFromWheels(wheels, wheel_separation_m);
  const Pose2Composition sum = compose(increment.start_from_end, arc.start_from_end);
  const Eigen::Matrix<double, 3, 2> J_sum_wheels = sum.J_ac_bc * arc.J_pose_wheels;
  OdometryIncrement result;
  result.start_from_end = sum.a_from_c;
  result.covariance = sum.J_ac_ab * increment.covariance * sum.J_ac_ab.transpose() +
                      J_sum_wheels * wheelCovariance(wheels, noise) * J_sum_wheels.transpose();
  result.distance_m = increment.distance_m + 0.5 * std::abs(wheels.left_m + wheels.right_m);
  result.rotation_rad =
      increment.rotation_rad + std::abs(wheels.right_m - wheels.left_m) / wheel_separation_m;
  return result;
}

}  // namespace bearing_calibration
