#pragma once

#include <Eigen/Core>
#include <limits>

#include "bearing_calibration/filter/state.h"

namespace bearing_calibration::core {

/// Log-likelihood within which an answer is still open: a thousandth as likely as the best one.
inline constexpr double kOpenGap = 7.0;

/// The next best answer to a record that is another mount than the one that is believed, and how it
/// was looked for.
struct RivalMount {
  /// Log-likelihood, half a chi-square, by which it is behind; infinite where none was found.
  double gap = std::numeric_limits<double>::infinity();
  Eigen::Vector3d mount = Eigen::Vector3d::Zero();  ///< x [m], y [m], yaw [rad]
  int minima = 0;                                   ///< fits begun at yaws all around
  int slips = 0;                                    ///< fits with a slip elsewhere, or one more

  /// It is not ruled out.
  bool isOpen() const { return gap < kOpenGap; }
  void offer(double other_gap, const Eigen::Vector3d& other_mount) {
    if (other_gap >= gap) return;
    gap = other_gap;
    mount = other_mount;
  }
};

/// Whether a mount's covariance does not explain it if the truth is as a rival says.
bool isAnotherMount(const MountEstimate& rival, const MountEstimate& mount);

/// Squared Mahalanobis distance of two independent estimates of one mount: chi-square with 3
/// degrees of freedom when both are honest.
double disagreement(const MountEstimate& a, const MountEstimate& b);

}  // namespace bearing_calibration::core
