#include "bearing_calibration/calibration/slip_suspicion.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {

double changeByHiddenSlip(const std::vector<Sight>& sights, const BatchEstimate& batch,
                          const BatchConfig& config, double gain) {
  if (config.slip_gain <= 0.0) return 0.0;  // the owner says that nothing slips
  BatchConfig suspicious = config;
  suspicious.slip_gain = std::min(gain, config.slip_gain);
  const BatchEstimate other =
      BatchEstimator(suspicious).estimate(sights, {batch.at_last_sight.mean, sights.size() - 1});
  if (!other.converged) return std::numeric_limits<double>::infinity();
  if (other.slips == batch.slips) return 0.0;
  Eigen::Vector3d change = (other.at_last_sight.mean - batch.at_last_sight.mean).tail<3>();
  change(2) = wrapAngle(change(2));
  const Eigen::Matrix3d covariance = batch.at_last_sight.covariance.bottomRightCorner<3, 3>();
  return change.dot(covariance.ldlt().solve(change));
}

bool hidesSlip(const std::vector<Sight>& sights, const BatchEstimate& batch,
               const BatchConfig& config) {
  constexpr double kSuspicion = 13.0;  // a gain that comes about by chance in one record of ten
  constexpr double kSameMount = 16.3;  // chi-square(3) of 0.1 %
  return changeByHiddenSlip(sights, batch, config, kSuspicion) > kSameMount;
}

}  // namespace bearing_calibration
