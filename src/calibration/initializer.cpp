#include "bearing_calibration/calibration/initializer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "bearing_calibration/calibration/closed_form.h"
#include "bearing_calibration/calibration/slip_rivals.h"
#include "bearing_calibration/calibration/start_candidates.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// The search runs on so many sights at most, whatever the record's length.
constexpr std::size_t kSightsOfSearch = 150;

double rangeOf(const Vector5& state) {
  return (state.head<2>() - state.segment<2>(CartesianIndex::kSensorX)).norm();
}

bool fitsWell(const BatchEstimate& batch, const InitializerConfig& config) {
  const double n = batch.degrees_of_freedom;
  return batch.converged && n > 0 && batch.inlierFraction() >= config.min_inlier_fraction &&
         batch.chi_square < n + config.max_chi_square_sigmas * std::sqrt(2.0 * n);
}

/// The best answer that the thinned record gives, and how much worse the next one is.
struct SearchResult {
  std::optional<BatchEstimate> best;
  double runner_up_margin = kInfinity;
};

/// Looks for the global optimum on a thinned record.
class Search {
 public:
  Search(const std::vector<Sight>& sights, const InitializerConfig& config)
      : sights_(thinned(sights, kSightsOfSearch)),
        posed_(poseSights(sights_)),
        config_(config),
        estimator_(config.batch) {}

  SearchResult run() {
    for (const SightWindow& window : startWindows(sights_.size())) {
      const FixedPathFit fit = findConsensus(posed_, window, config_.seed);
      if (!fit.state_at_first.isZero()) consider(fit.state_at_first, window.middle());
      if (result_.best && fitsWell(*result_.best, config_)) break;
    }
    if (result_.best) challenge();
    return result_;
  }

 private:
  BatchEstimate refine(const Vector5& state_at_first, std::size_t sight) const {
    return estimator_.estimate(sights_, {stateAt(posed_[sight], state_at_first), sight});
  }

  void consider(const Vector5& state_at_first, std::size_t sight) {
    BatchEstimate batch = refine(state_at_first, sight);
    if (!batch.at_last_sight.mean.allFinite()) return;
    if (!result_.best || batch.cost < result_.best->cost) result_.best = std::move(batch);
  }

  /// Compares the best answer with every other minimum. Those that a sound record rules out at once
  /// are not refined.
  void challenge() {
    constexpr int kMostRefined = 3;
    const Vector5 last = result_.best->at_last_sight.mean;
    Vector5 found = last;
    found.head<2>() = posed_.back().first_from_base * Eigen::Vector2d(last.head<2>());
    // fitted again, as the others are, to the path that the odometry alone gives
    const double found_cost =
        fitOnFixedPath(posed_, found, FixedPathWeight{posed_.size() / 2}).cost;
    int refined = 0;
    for (const FixedPathFit& other : findOtherMinima(posed_, found)) {
      double margin = other.cost - found_cost;
      if (margin < config_.min_runner_up_margin && refined < kMostRefined) {
        ++refined;
        const BatchEstimate batch = refine(other.state_at_first, posed_.size() / 2);
        if (isSameMount(batch.at_last_sight.mean, last)) continue;
        margin = batch.cost - result_.best->cost;
        if (margin < 0.0) {
          result_.best = batch;
          margin = -margin;
        }
      }
      result_.runner_up_margin = std::min(result_.runner_up_margin, margin);
    }
  }

  std::vector<Sight> sights_;
  std::vector<PosedSight> posed_;
  const InitializerConfig& config_;
  BatchEstimator estimator_;
  SearchResult result_;
};

/// What the motion alone rules out.
StartObstacle motionObstacle(std::size_t sights, const MotionSummary& motion,
                             const InitializerConfig& config) {
  if (sights < static_cast<std::size_t>(config.min_sights)) return StartObstacle::kTooFewSights;
  if (motion.extent_m < config.min_extent_m) return StartObstacle::kTooShortPath;
  if (motion.turn_rad < config.min_turn_rad) return StartObstacle::kNoTurn;
  if (motion.second_curvature_m < config.min_second_curvature_m)
    return StartObstacle::kOneCurvature;
  return StartObstacle::kNone;
}

bool isWellKnown(const CartesianEstimate& estimate, double range, const InitializerConfig& config) {
  const Vector5 stddev = estimate.covariance.diagonal().cwiseSqrt();
  return stddev.segment<2>(CartesianIndex::kSensorX).maxCoeff() < config.max_position_stddev_m &&
         stddev(CartesianIndex::kSensorYaw) < config.max_yaw_stddev_rad &&
         stddev.head<2>().maxCoeff() < config.max_light_stddev_per_range * range;
}

/// What the answer itself lacks.
StartObstacle answerObstacle(const StartAttempt& attempt, const BatchEstimate& batch,
                             const InitializerConfig& config) {
  const double range = rangeOf(attempt.estimate.mean);
  if (!batch.converged) return StartObstacle::kNoSolution;
  if (!fitsWell(batch, config)) return StartObstacle::kPoorFit;
  if (range < config.min_light_distance_m) return StartObstacle::kLightTooNear;
  if (attempt.motion.path_m < config.min_path_per_range * range) {
    return StartObstacle::kTooShortPath;
  }
  if (!isWellKnown(attempt.estimate, range, config)) return StartObstacle::kWeakDirection;
  if (attempt.runner_up_margin < config.min_runner_up_margin) return StartObstacle::kAmbiguous;
  return StartObstacle::kNone;
}

}  // namespace

std::vector<std::string> InitializerConfig::validate() const {
  constexpr int kUnknowns = 5;
  Requirements require;
  require.that(min_sights > kUnknowns, "start/min_sights must be greater than " +
                                           std::to_string(kUnknowns) + ", but is " +
                                           std::to_string(min_sights));
  require.notNegative("start/min_extent", min_extent_m);
  require.notNegative("start/min_path_per_range", min_path_per_range);
  require.notNegative("start/min_turn", min_turn_rad);
  require.notNegative("start/min_second_curvature", min_second_curvature_m);
  require.positive("start/max_position_stddev", max_position_stddev_m);
  require.positive("start/max_yaw_stddev", max_yaw_stddev_rad);
  require.positive("start/max_light_stddev_per_range", max_light_stddev_per_range);
  require.notNegative("start/min_light_distance", min_light_distance_m);
  require.positive("start/max_chi_square_sigmas", max_chi_square_sigmas);
  require.between("start/min_inlier_fraction", min_inlier_fraction, 0.0, 1.0);
  require.notNegative("start/min_runner_up_margin", min_runner_up_margin);
  require.add(record.validate());
  require.add(batch.validate());
  return require.errors();
}

const char* nameOf(StartObstacle obstacle) {
  switch (obstacle) {
    case StartObstacle::kNone:
      return "none";
    case StartObstacle::kTooFewSights:
      return "too few sights";
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

StartAttempt findStart(const std::vector<Sight>& sights, const InitializerConfig& config) {
  StartAttempt attempt;
  attempt.motion = summariseMotion(sights);
  attempt.obstacle = motionObstacle(sights.size(), attempt.motion, config);
  if (attempt.obstacle != StartObstacle::kNone) return attempt;

  const SearchResult search = Search(sights, config).run();
  attempt.obstacle = StartObstacle::kNoSolution;
  if (!search.best) return attempt;
  const BatchEstimate batch =
      BatchEstimator(config.batch)
          .estimate(sights, {search.best->at_last_sight.mean, sights.size() - 1});
  attempt.estimate = batch.at_last_sight;
  attempt.weakest = weakestDirection(attempt.estimate);
  attempt.chi_square = batch.chi_square;
  attempt.degrees_of_freedom = batch.degrees_of_freedom;
  attempt.inlier_fraction = batch.inlierFraction();
  attempt.runner_up_margin = search.runner_up_margin;
  attempt.slips = static_cast<int>(batch.slips.size());
  attempt.bearing_correlation = batch.correlation;
  attempt.obstacle = answerObstacle(attempt, batch, config);
  if (!attempt.ready()) return attempt;
  attempt.estimate = averageOverSlips(sights, batch, config.batch).estimate;
  attempt.weakest = weakestDirection(attempt.estimate);
  attempt.obstacle = answerObstacle(attempt, batch, config);
  return attempt;
}

Initializer::Initializer(const InitializerConfig& config)
    : config_(validated(config)), record_(config.record) {}

}  // namespace bearing_calibration
