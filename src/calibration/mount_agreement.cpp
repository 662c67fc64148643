#include "bearing_calibration/calibration/mount_agreement.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
double disagreement(const MountEstimate& a, const MountEstimate& b) {
  Eigen::Vector3d difference = a.mean - b.mean;
  difference.z() = wrapAngle(difference.z());
  return difference.dot((a.covariance + b.covariance).ldlt().solve(difference));
}

CartesianEstimate withKnownMount(const CartesianEstimate& estimate, const MountEstimate& known) {
  const Eigen::Matrix<double, 5, 3> PHt = estimate.covariance.rightCols<3>();
  const Eigen::Matrix3d S = PHt.bottomRows<3>() + known.covariance;
  const Eigen::Matrix<double, 5, 3> K = S.ldlt().solve(PHt.transpose()).transpose();
  Eigen::Vector3d innovation = known.mean - mountFromCartesian(estimate).mean;
  innovation.z() = wrapAngle(innovation.z());
  CartesianEstimate together{estimate.mean + K * innovation,
                             estimate.covariance - K * PHt.transpose()};
  together.covariance = 0.5 * (together.covariance + together.covariance.transpose().eval());
  together.mean(CartesianIndex::kSensorYaw) = wrapAngle(together.sensorYaw());
  return together;
}

}  // namespace bearing_calibration
