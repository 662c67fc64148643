#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace bearing_calibration::core {

/// The outline about `centre_m` of what lies within `sigmas` standard deviations along each axis
/// (Mahalanobis), as a closed line: `segments` + 1 points from the major axis on, the first again
/// as the last. A variance below zero, by rounding, counts as none; NaN stays NaN.
std::vector<Eigen::Vector2d> ellipseOutline(const Eigen::Matrix2d& covariance_m2, double sigmas,
                                            const Eigen::Vector2d& centre_m, int segments);

/// A path for drawing: points some way apart. However long it gets, its memory is bounded: when it
/// is full, every second point is dropped and the spacing doubles.
class DrivenPath {
 public:
  /// @throws std::invalid_argument unless spacing_m > 0 and most_points >= 2.
  DrivenPath(double spacing_m, std::size_t most_points);

  /// Keeps the position when it is far enough from the last one that was kept.
  void add(const Eigen::Vector2d& position_m);
  void clear();

  /// The first one is where the path began.
  const std::vector<Eigen::Vector2d>& points_m() const { return points_m_; }

 private:
  double first_spacing_m_;
  double spacing_m_;
  std::size_t most_points_;
  std::vector<Eigen::Vector2d> points_m_;
};

}  // namespace bearing_calibration::core
