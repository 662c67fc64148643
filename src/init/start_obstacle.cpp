#include "bearing_calibration/init/start_obstacle.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {
namespace {

bool isWellKnown(const CartesianEstimate& estimate, double range, double extent_m,
                 const InitializerConfig& config) {
  const Vector5 stddev = estimate.covariance.diagonal().cwiseSqrt();
  const double max_position_stddev_m =
      std::min(config.max_position_stddev_m, config.max_position_stddev_per_extent * extent_m);
  return stddev.segment<2>(CartesianIndex::kSensorX).maxCoeff() < max_position_stddev_m &&
         stddev(CartesianIndex::kSensorYaw) < config.max_yaw_stddev_rad &&
         stddev.head<2>().maxCoeff() < config.max_light_stddev_per_range * range;
}

}  // namespace

bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config) {
  const double n = batch.degrees_of_freedom;
  return batch.converged && n > 0 && batch.inlierFraction() >= config.min_inlier_fraction &&
         batch.chi_square < n + config.max_chi_square_sigmas * std::sqrt(2.0 * n);
}

StartObstacle motionObstacle(std::size_t observations, const MotionSummary& motion,
                             const InitializerConfig& config) {
  if (observations < static_cast<std::size_t>(config.min_observations))
    return StartObstacle::kTooFewObservations;
  if (motion.extent_m <=
      std::min(config.min_extent_m, config.min_extent_per_noise * motion.extent_noise_m)) {
    return StartObstacle::kTooShortPath;
  }
  if (motion.turn_rad < config.min_turn_rad) return StartObstacle::kNoTurn;
  if (motion.second_curvature_m < config.min_second_curvature_m)
    return StartObstacle::kOneCurvature;
  return StartObstacle::kNone;
}

StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config) {
  const CartesianEstimate estimate = attempt.estimate.cartesian();
  const double range = estimate.range();
  if (!batch.converged) return StartObstacle::kNoSolution;
  if (!fitsWell(batch, config)) return StartObstacle::kPoorFit;
  if (range < config.min_light_distance_m) return StartObstacle::kLightTooNear;
  const double min_extent_m = std::min(config.min_extent_m, config.min_extent_per_range * range);
  if (attempt.motion.extent_m < min_extent_m ||
      attempt.motion.path_m < config.min_path_per_range * range) {
    return StartObstacle::kTooShortPath;
  }
  if (!isWellKnown(estimate, range, attempt.motion.extent_m, config))
    return StartObstacle::kWeakDirection;
  if (2.0 * attempt.rival.gap < config.min_runner_up_margin) return StartObstacle::kAmbiguous;
  return StartObstacle::kNone;
}

const char* nameOf(StartObstacle obstacle) {
  switch (obstacle) {
    case StartObstacle::kNone:
      return "none";
    case StartObstacle::kTooFewObservations:
      return "too few observations";
    case StartObstacle::kTooShortPath:
      return "too short a path";
    case StartObstacle::kNoTurn:
      return "no turn";
    case StartObstacle::kOneCurvature:
      return "one curvature only";
    case StartObstacle::kNoSolution:
      return "no solution";
    case StartObstacle::kPoorFit:
      return "poor fit";
    case StartObstacle::kLightTooNear:
      return "light too near";
    case StartObstacle::kWeakDirection:
      return "weak direction";
    case StartObstacle::kAmbiguous:
      return "ambiguous";
  }
  return "unknown";
}

}  // namespace bearing_calibration::core
