#pragma once

#include <Eigen/Core>
#include <vector>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// Where the base's centre may go, in the base frame of the start. Parameter group `region`.
struct Region {
  double radius_m = 0.0;  ///< disc about the start; used without a polygon
  /// Corners in either order [m]; at least three, or none for the disc. The start must lie inside.
  std::vector<Eigen::Vector2d> polygon_m;

  void declare(Parameters& params);

  /// Least distance of a straight way to the border [m], negative when a part of it lies outside:
  /// minus that of its end which does, or a nanometre where it only touches or crosses the border.
  double clearance(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  double clearance(const Eigen::Vector2d& point) const { return clearance(point, point); }
};

}  // namespace bearing_calibration::core
