#include "bearing_calibration/judge/mount_agreement.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
double disagreement(const MountEstimate& a, const MountEstimate& b) {
  Eigen::Vector3d difference = a.mean - b.mean;
  difference.z() = wrapAngle(difference.z());
  return difference.dot((a.covariance + b.covariance).ldlt().solve(difference));
}

}  // namespace bearing_calibration::core
