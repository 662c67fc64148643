#include "bearing_calibration/calibration/mount_agreement.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
double disagreement(const MountEstimate& a, const MountEstimate& b) {
  Eigen::Vector3d difference = a.mean - b.mean;
  difference.z() = wrapAngle(difference.z());
  return difference.dot((a.covariance + b.covariance).ldlt().solve(difference));
}

RobotEstimate withKnownMount(const RobotEstimate& estimate, const MountEstimate& known) {
  constexpr int kSize = 5 + kErrorCount;
  const Gaussian<kSize> before = estimate.joint<kErrorCount>();
  const Eigen::Matrix<double, kSize, 3> PHt =
      before.covariance.middleCols<3>(CartesianIndex::kSensorX);
  const Eigen::Matrix3d S = PHt.middleRows<3>(CartesianIndex::kSensorX) + known.covariance;
  const Eigen::Matrix<double, kSize, 3> K = S.ldlt().solve(PHt.transpose()).transpose();
  Eigen::Vector3d innovation = known.mean - mountFromCartesian(estimate.cartesian).mean;
  innovation.z() = wrapAngle(innovation.z());
  Gaussian<kSize> together{before.mean + K * innovation, before.covariance - K * PHt.transpose()};
  together.covariance = 0.5 * (together.covariance + together.covariance.transpose().eval());
  double& yaw = together.mean(CartesianIndex::kSensorYaw);
  yaw = wrapAngle(yaw);
  return RobotEstimate::from<kErrorCount>(together);
}

}  // namespace bearing_calibration
