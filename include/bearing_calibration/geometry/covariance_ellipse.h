#pragma once

#include <Eigen/Core>
#include <vector>

namespace bearing_calibration::core {

/// All points of the plane at one Mahalanobis distance from a mean, for drawing.
struct CovarianceEllipse {
  double semi_major_m = 0.0;
  double semi_minor_m = 0.0;
  double major_direction_rad = 0.0;  ///< of the major axis, which has no sign
};

/// The ellipse at `sigmas` standard deviations along each of its axes. A variance below zero, by
/// rounding, counts as none; NaN stays NaN.
CovarianceEllipse covarianceEllipse(const Eigen::Matrix2d& covariance_m2, double sigmas);

/// Its outline about `centre_m` as a closed line: `segments` + 1 points, the first again as the
/// last.
std::vector<Eigen::Vector2d> outlineOf(const CovarianceEllipse& ellipse,
                                       const Eigen::Vector2d& centre_m, int segments);

}  // namespace bearing_calibration::core
