#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bearing_calibration/record/scatter.h"

namespace bearing_calibration::core {

/// What a fit says of a jump of the mount (x, y, yaw) at one of its observations: how much all
/// observations together pull at such a jump, and the variance of that pull, which is the
/// information on it.
struct MountDisplacement {
  Eigen::Vector3d pull = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// A jump as a test: that of the mount before an observation against the mount after it, both given
/// all observations, linearised about the fit of all. (Two fits, one for each part, say the same
/// where both are well determined, and something arbitrary where one is not.)
struct DisplacementTest {
  double gain = 0.0;   ///< taken off the cost: chi-square of `directions` degrees without a jump
  int directions = 0;  ///< in which the jump can be told, of 3
  Eigen::Vector3d jump = Eigen::Vector3d::Zero();  ///< most probable one, along those
};

/// Only directions count in which the jump is known better than 10 cm or 0.1 rad: in the others the
/// linearisation says nothing.
DisplacementTest testDisplacement(const MountDisplacement& jump);

/// How much mounts scatter that two parts of a record tell, divided at each of these observations.
/// @param begin,end  of the jumps
Scatter scatterOf(const std::vector<MountDisplacement>& jumps, std::size_t begin, std::size_t end);

}  // namespace bearing_calibration::core
