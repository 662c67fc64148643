#include "bearing_calibration/geometry/pictures.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>

#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration::core {

std::vector<Eigen::Vector2d> ellipseOutline(const Eigen::Matrix2d& covariance_m2, double sigmas,
                                            const Eigen::Vector2d& centre_m, int segments) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(covariance_m2);  // closed form; eigenvalues in increasing order
  const auto semiAxis = [&](int i) {
    const double variance_m2 = solver.eigenvalues()(i);
    return variance_m2 < 0.0 ? 0.0 : sigmas * std::sqrt(variance_m2);
  };
  const Eigen::Vector2d direction = solver.eigenvectors().col(1);
  const Eigen::Vector2d major = semiAxis(1) * direction;
  const Eigen::Vector2d minor = semiAxis(0) * perpendicular(direction);
  std::vector<Eigen::Vector2d> outline;
  for (int i = 0; i <= segments; ++i) {
    const double angle = 2.0 * kPi * (i % segments) / segments;
    outline.emplace_back(centre_m + std::cos(angle) * major + std::sin(angle) * minor);
  }
  return outline;
}

DrivenPath::DrivenPath(double spacing_m, std::size_t most_points)
    : first_spacing_m_(spacing_m), spacing_m_(spacing_m), most_points_(most_points) {
  if (!(spacing_m > 0.0) || most_points < 2) {
    throw std::invalid_argument("a path needs a spacing above 0 and room for two points");
  }
}

void DrivenPath::add(const Eigen::Vector2d& position_m) {
  if (!points_m_.empty() && (position_m - points_m_.back()).norm() < spacing_m_) return;
  if (points_m_.size() == most_points_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points_m_.size(); i += 2) points_m_[kept++] = points_m_[i];
    points_m_.resize(kept);
    spacing_m_ *= 2.0;
  }
  points_m_.push_back(position_m);
}

void DrivenPath::clear() {
  points_m_.clear();
  spacing_m_ = first_spacing_m_;
}

}  // namespace bearing_calibration::core
