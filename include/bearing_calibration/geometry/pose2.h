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

/// A composition with its Jacobians; poses are perturbed by adding to (x, y, yaw).
struct Pose2Composition {
  Pose2 a_from_c;
  Eigen::Matrix3d J_ac_ab;  ///< d(a_from_c) / d(a_from_b)
  Eigen::Matrix3d J_ac_bc;  ///< d(a_from_c) / d(b_from_c)
};

inline Pose2Composition compose(const Pose2& a_from_b, const Pose2& b_from_c) {
  const Eigen::Matrix2d R_ab = rotation2(a_from_b.yaw_rad);
  Pose2Composition result{a_from_b * b_from_c, Eigen::Matrix3d::Identity(),
                          Eigen::Matrix3d::Identity()};
  result.J_ac_ab.topRightCorner<2, 1>() = perpendicular(R_ab * b_from_c.position_m);
  result.J_ac_bc.topLeftCorner<2, 2>() = R_ab;
  return result;
}

}  // namespace bearing_calibration::core
