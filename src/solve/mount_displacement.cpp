#include "bearing_calibration/solve/mount_displacement.h"

#include <Eigen/Eigenvalues>

#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {

DisplacementTest testDisplacement(const MountDisplacement& jump) {
  constexpr double kTellable_m = 0.1;
  constexpr double kTellable_rad = 0.1;
  const Eigen::Vector3d unit(kTellable_m, kTellable_m, kTellable_rad);
  const Eigen::Matrix3d information = unit.asDiagonal() * jump.information * unit.asDiagonal();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(information);
  DisplacementTest test;
  for (int i = 0; i < 3; ++i) {
    const double known = solver.eigenvalues()(i);  // 1: to one unit
    if (!(known > 1.0)) continue;
    const Eigen::Vector3d direction = unit.cwiseProduct(solver.eigenvectors().col(i));
    const double pull = direction.dot(jump.pull);
    ++test.directions;
    test.gain += pull * pull / known;
    test.jump += direction * (pull / known);
  }
  return test;
}

Scatter scatterOf(const std::vector<MountDisplacement>& jumps, std::size_t begin, std::size_t end) {
  Scatter scatter;
  for (std::size_t i = begin; i < end; ++i) {
    const DisplacementTest test = testDisplacement(jumps[i]);
    if (test.directions < kMountSize) continue;
    scatter.gain_sum += test.gain;
    scatter.largest_gain = std::max(scatter.largest_gain, test.gain);
    ++scatter.observations;
  }
  return scatter;
}

}  // namespace bearing_calibration::core
