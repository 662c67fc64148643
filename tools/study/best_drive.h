#pragma once

#include <cstdint>
#include <vector>

#include "tools/study/driven_case.h"

namespace bearing_calibration::core {

/// A drive that somebody who knows mount and light could plan at home.
struct BestDrive {
  std::vector<MotionPrimitive> primitives;
  Eigen::Matrix3d mount_covariance = Eigen::Matrix3d::Zero();  ///< at its end: the Cramer-Rao bound
  double least_distance_m = 0.0;                               ///< to the light
};

/// Looks for the drive of `duration_s` that lowers the bound of the mount's determinant most: the
/// planner's own primitives on the true state, bettered by random changes. Found, not proven to be
/// best.
BestDrive findBestDrive(const DrivenCase& driven, double duration_s, int changes,
                        std::uint64_t seed);

}  // namespace bearing_calibration::core
