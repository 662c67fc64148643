#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace bearing_calibration::core {

struct Circle {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< (u, v)
  double radius_px = 0.0;
};

/// The circle through three points; none when they lie in a line.
std::optional<Circle> circleThrough(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                    const Eigen::Vector2d& c);

struct CircleFit {
  Circle circle;
  /// Of (centre u, centre v, radius), from the points' own scatter: neighbours within ten degrees
  /// may err together.
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();
  double scatter_px = 0.0;    ///< robust standard deviation of the distances from the circle
  std::vector<bool> belongs;  ///< to the circle, by point: not an outlier
};

/// The circle of least (Tukey) loss of the points' distances from it, beginning at `start`; as long
/// as fewer than half of the points are strangers, these do not count.
/// @return none when the points do not determine a circle.
std::optional<CircleFit> fitCircle(const std::vector<Eigen::Vector2d>& points_px,
                                   const Circle& start);

}  // namespace bearing_calibration::core
