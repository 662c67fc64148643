#include "bearing_calibration/solve/observability.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

MotionSummary summariseMotion(const std::vector<Observation>& observations) {
  // Turns are compared with ways at this distance from the base's centre: about a robot's size.
  constexpr double kLever_m = 0.3;
  constexpr double kUncounted_rad = 0.5;  // of a break in the readings: a filter cannot follow it
  MotionSummary summary;
  Pose2 first_from_base;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  Eigen::Matrix2d directions = Eigen::Matrix2d::Zero();
  double variance_m2 = 0.0;
  for (std::size_t i = 1; i < observations.size(); ++i) {
    const OdometryIncrement& motion = observations[i].motion;
    summary.path_m += motion.distance_m;
    summary.turn_rad += motion.rotation_rad;
    first_from_base = first_from_base * motion.start_from_end;
    if (motion.covariance(2, 2) < kUncounted_rad * kUncounted_rad) {
      variance_m2 += 0.5 * motion.covariance.topLeftCorner<2, 2>().trace();
    }
    low = low.cwiseMin(first_from_base.position_m);
    high = high.cwiseMax(first_from_base.position_m);
    const Eigen::Vector2d step(
        std::copysign(motion.distance_m, motion.start_from_end.position_m.x()),
        std::copysign(kLever_m * motion.rotation_rad, motion.start_from_end.yaw_rad));
    if (step.norm() > 0.0) directions += step * step.transpose() / step.norm();
  }
  summary.extent_m = (high - low).norm();
  summary.extent_noise_m = std::sqrt(variance_m2);
  summary.second_curvature_m = std::max(0.0, eigenOf(directions).values(0));
  return summary;
}

WeakestDirection weakestDirection(const CartesianEstimate& estimate) {
  WeakestDirection weakest;
  weakest.lever_m = estimate.range();
  Vector5 scale = Vector5::Ones();
  scale(CartesianIndex::kSensorYaw) = weakest.lever_m;
  const Matrix5 lengths = scale.asDiagonal() * estimate.covariance * scale.asDiagonal();
  const SymmetricEigen axes = eigenOf(lengths);
  weakest.direction = axes.vectors.col(4);
  weakest.stddev_m = std::sqrt(std::max(0.0, axes.values(4)));
  return weakest;
}

StateEstimate cramerRaoBound(const std::vector<Observation>& observations,
                             const std::vector<Eigen::Vector2d>& light_in_base,
                             const Eigen::Vector3d& mount, const ErrorVector& errors,
                             const ErrorPriors& priors) {
  std::vector<ObservationWeight> weights;
  RecordPath path{{}, mount, errors};
  for (std::size_t i = 0; i < observations.size(); ++i) {
    weights.push_back(
        {observations[i].azimuth_variance_rad2, observations[i].azimuth_variance_rad2});
    path.points.push_back({light_in_base[i]});
  }
  return smooth(observations, weights, path, kFreePass, priors).last;
}

}  // namespace bearing_calibration::core
