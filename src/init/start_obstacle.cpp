#include "bearing_calibration/init/start_obstacle.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {
namespace {

bool isWellKnown(const CartesianEstimate& estimate, double range, double extent_m) {
  const Vector5 stddev = estimate.covariance.diagonal().cwiseSqrt();
  const double max_position_stddev_m = std::min(
      StartLimits::kMaxPositionStddev_m, StartLimits::kMaxPositionStddevPerExtent * extent_m);
  return stddev.segment<2>(CartesianIndex::kSensorX).maxCoeff() < max_position_stddev_m &&
         stddev(CartesianIndex::kSensorYaw) < StartLimits::kMaxYawStddev_rad &&
         stddev.head<2>().maxCoeff() < StartLimits::kMaxLightStddevPerRange * range;
}

/// So often that the fit rests on it: who has turned on the spot and driven straight sees a far
/// light as one that would be where he turned.
bool isOftenOverLight(const RecordPath& path) {
  std::size_t over_light = 0;
  for (std::size_t i = 0; i < path.points.size(); ++i) {
    if (path.rangeAt(i, 0) < StartLimits::kOverLight_m) ++over_light;
  }
  return over_light > StartLimits::kMaxOverLight * path.points.size();
}

}  // namespace

bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config) {
  const double n = batch.degrees_of_freedom;
  return batch.hasSettled(config.min_inlier_fraction) && n > 0 &&
         batch.chi_square < n + StartLimits::kMaxChiSquareSigmas * std::sqrt(2.0 * n);
}

StartObstacle motionObstacle(std::size_t observations, const MotionSummary& motion) {
  if (observations < StartLimits::kMinObservations) return StartObstacle::kTooFewObservations;
  if (motion.extent_m <= std::min(StartLimits::kMinExtent_m,
                                  StartLimits::kMinExtentPerNoise * motion.extent_noise_m)) {
    return StartObstacle::kTooShortPath;
  }
  if (motion.turn_rad < StartLimits::kMinTurn_rad) return StartObstacle::kNoTurn;
  if (motion.second_curvature_m < StartLimits::kMinSecondCurvature_m)
    return StartObstacle::kOneCurvature;
  return StartObstacle::kNone;
}

StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config) {
  const CartesianEstimate estimate = attempt.estimate.cartesian();
  const double range = estimate.range();
  if (!batch.converged) return StartObstacle::kNoSolution;
  if (!fitsWell(batch, config)) return StartObstacle::kPoorFit;
  if (range < StartLimits::kMinLightDistance_m || isOftenOverLight(batch.path))
    return StartObstacle::kLightTooNear;
  const double min_extent_m =
      std::min(StartLimits::kMinExtent_m, StartLimits::kMinExtentPerRange * range);
  if (attempt.motion.extent_m < min_extent_m ||
      attempt.motion.path_m < StartLimits::kMinPathPerRange * range) {
    return StartObstacle::kTooShortPath;
  }
  if (!isWellKnown(estimate, range, attempt.motion.extent_m)) return StartObstacle::kWeakDirection;
  if (2.0 * attempt.rival.gap < StartLimits::kMinRunnerUpMargin) return StartObstacle::kAmbiguous;
  return StartObstacle::kNone;
}

const char* nameOf(StartObstacle obstacle) {
  static constexpr std::array<const char*, 10> kNames{
      "none",      "too few observations", "too short a path",
      "no turn",   "one curvature only",   "no solution",
      "poor fit",  "light too near",       "weak direction",
      "ambiguous",
  };
  static_assert(kNames.size() == static_cast<std::size_t>(StartObstacle::kAmbiguous) + 1);
  return kNames.at(static_cast<std::size_t>(obstacle));
}

}  // namespace bearing_calibration::core
