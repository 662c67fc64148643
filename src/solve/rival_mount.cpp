#include "bearing_calibration/solve/rival_mount.h"

#include <Eigen/Cholesky>

namespace bearing_calibration::core {

bool isAnotherMount(const MountEstimate& rival, const MountEstimate& mount) {
  constexpr double kAgreement = 16.3;  // chi-square that one right answer in a thousand has
  const Eigen::LDLT<Eigen::Matrix3d> covariance(mount.covariance);
  const Eigen::Vector3d off = mountDifference(rival.mean, mount.mean);
  // what it would be on the average
  return off.dot(covariance.solve(off)) + covariance.solve(rival.covariance).trace() > kAgreement;
}

double disagreement(const MountEstimate& a, const MountEstimate& b) {
  const Eigen::Vector3d off = mountDifference(a.mean, b.mean);
  return off.dot((a.covariance + b.covariance).ldlt().solve(off));
}

}  // namespace bearing_calibration::core
