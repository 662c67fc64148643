#include "bearing_calibration/calibration/mount_agreement.h"

#include <Eigen/Cholesky>

#include "bearing_calibration/calibration/light_track.h"
#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

constexpr std::size_t kFewestSights = 10;  // below it a part says nothing for itself

/// Index of the first sight after half of the record's motion; a turn counts as the way of a point
/// half a metre from the centre.
std::size_t middleByMotion(const std::vector<Sight>& sights) {
  constexpr double kLever_m = 0.5;
  const auto length = [](const Sight& sight) {
    return sight.motion.distance_m + kLever_m * sight.motion.rotation_rad;
  };
  double whole_m = 0.0;
  for (const Sight& sight : sights) whole_m += length(sight);
  double covered_m = 0.0;
  std::size_t middle = 0;
  while (middle < sights.size() && covered_m < 0.5 * whole_m) covered_m += length(sights[middle++]);
  return middle;
}

}  // namespace

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

std::optional<MountEstimate> estimatePart(const std::vector<Sight>& sights, const Vector5& at_last,
                                          std::size_t begin, std::size_t end,
                                          const BatchConfig& config) {
  if (begin + kFewestSights > end || end > sights.size()) return std::nullopt;
  const std::vector<Vector5> states = trackLight(sights, {at_last, sights.size() - 1}).states;
  const std::vector<Sight> part(sights.begin() + static_cast<std::ptrdiff_t>(begin),
                                sights.begin() + static_cast<std::ptrdiff_t>(end));
  const BatchEstimate estimate =
      BatchEstimator(config).estimate(part, {states[end - 1], part.size() - 1});
  if (!estimate.converged) return std::nullopt;
  return mountFromCartesian(estimate.at_last_sight);
}

std::optional<double> halvesDisagreement(const std::vector<Sight>& sights, const Vector5& at_last,
                                         const BatchConfig& config) {
  const std::size_t middle = middleByMotion(sights);
  const auto earlier = estimatePart(sights, at_last, 0, middle, config);
  const auto later = estimatePart(sights, at_last, middle, sights.size(), config);
  if (!earlier || !later) return std::nullopt;
  return disagreement(*earlier, *later);
}

}  // namespace bearing_calibration
