#include "bearing_calibration/geometry/covariance_ellipse.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {
namespace {

double axis(double variance_m2, double sigmas) {
  return variance_m2 < 0.0 ? 0.0 : sigmas * std::sqrt(variance_m2);
}

}  // namespace

CovarianceEllipse covarianceEllipse(const Eigen::Matrix2d& covariance_m2, double sigmas) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(covariance_m2);  // closed form; eigenvalues in increasing order
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  return {axis(solver.eigenvalues()(1), sigmas), axis(solver.eigenvalues()(0), sigmas),
          std::atan2(major.y(), major.x())};
}

std::vector<Eigen::Vector2d> outlineOf(const CovarianceEllipse& ellipse,
                                       const Eigen::Vector2d& centre_m, int segments) {
  const Eigen::Matrix2d R = rotation2(ellipse.major_direction_rad);
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i <= segments; ++i) {
    const double angle = 2.0 * kPi * (i % segments) / segments;
    outline.emplace_back(centre_m + R * Eigen::Vector2d(ellipse.semi_major_m * std::cos(angle),
                                                        ellipse.semi_minor_m * std::sin(angle)));
  }
  return outline;
}

}  // namespace bearing_calibration::core
