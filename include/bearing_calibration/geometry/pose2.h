#pragma once

#include <Eigen/Core>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

inline Eigen::Matrix2d rotation2(double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return (Eigen::Matrix2d() << c, -s, s, c).finished();
}

/// v turned by +90 degrees.
inline Eigen::Vector2d perpendicular(const Eigen::Vector2d& v) { return {-v.y(), v.x()}; }

/// A rigid motion of the plane, an element of SE(2). Named a_from_b, it is the pose of frame b in
/// frame a and maps points of b to a: point_in_a = a_from_b * point_in_b.
struct Pose2 {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0.0;  ///< in [-pi, pi]

  Pose2 inverse() const { return {-(rotation2(-yaw_rad) * position_m), wrapAngle(-yaw_rad)}; }
};

/// a_from_c = a_from_b * b_from_c
inline Pose2 operator*(const Pose2& a_from_b, const Pose2& b_from_c) {
  return {a_from_b.position_m + rotation2(a_from_b.yaw_rad) * b_from_c.position_m,
          wrapAngle(a_from_b.yaw_rad + b_from_c.yaw_rad)};
}

inline Eigen::Vector2d operator*(const Pose2& a_from_b, const Eigen::Vector2d& point_in_b) {
  return a_from_b.position_m + rotation2(a_from_b.yaw_rad) * point_in_b;
}

}  // namespace bearing_calibration::core
