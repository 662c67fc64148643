#include "bearing_calibration/solve/rival_mount.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

bool isAnotherMount(const MountEstimate& rival, const MountEstimate& mount) {
  constexpr double kAgreement = 16.3;  // chi-square that one right answer in a thousand has
  const Eigen::LDLT<Eigen::Matrix3d> covariance(mount.covariance);
  Eigen::Vector3d off = rival.mean - mount.mean;
  off.z() = wrapAngle(off.z());
  // what it would be on the average
  return off.dot(covariance.solve(off)) + covariance.solve(rival.covariance).trace() > kAgreement;
}

}  // namespace bearing_calibration::core
