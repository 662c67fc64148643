#include "bearing_calibration/init/initializer.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/init/other_answers.h"
#include "bearing_calibration/init/start_candidates.h"
#include "bearing_calibration/init/start_obstacle.h"
#include "bearing_calibration/noise/noise_review.h"
#include "bearing_calibration/solve/slip_hypotheses.h"

namespace bearing_calibration::core {
namespace {

/// The best fit of a record, and the next one.
struct Answer {
  std::optional<BatchEstimate> fit;
  RivalMount rival;
};

/// Robots to begin a search with: as believed, or with a late camera and wheels that turn it by
/// another angle, so near to each other that a batch finds from one of them to the truth.
/// @param turn_rad  of the stretch that is searched: on a short one, wheels are all alike
std::vector<ErrorVector> errorHypotheses(const ErrorPriors& priors, double turn_rad) {
  constexpr double kTellableTurn_rad = 0.2;
  const double late_stddev_s = priors.stddev(placeOf<TimeOffset>());
  // A mean scale of the wheels turns the robot by another angle, as their separation does.
  const double turn_stddev = std::sqrt(0.5) * priors.stddev(placeOf<WheelScales>());
  std::vector<double> lates = {0.0};
  std::vector<double> turns = {0.0};
  if (late_stddev_s > 0.0) lates = {0.0, 0.5, 1.0, 1.5, -0.5};  // cameras are rather late
  if (turn_stddev * turn_rad > kTellableTurn_rad) turns = {-0.5, 0.5, -1.5, 1.5};
  std::vector<ErrorVector> hypotheses;
  for (double late : lates) {
    for (double turn : turns) {
      ErrorVector errors = ErrorVector::Zero();
      errors(placeOf<TimeOffset>()) = late * late_stddev_s;
      errors.segment<WheelScales::kSize>(placeOf<WheelScales>()).setConstant(turn * turn_stddev);
      hypotheses.push_back(errors);
    }
  }
  return hypotheses;
}

/// Looks for the global optimum on a thinned record.
class Search {
 public:
  Search(const std::vector<Observation>& observations, const InitializerConfig& config)
      : observations_(thinned(observations, kObservationsOfSearch)), config_(config) {}

  Answer run() {
    for (const Stretch& window : startWindows(observations_.size())) {
      considerAll(window);
      if (result_.fit && fitsWell(*result_.fit, config_)) break;
    }
    if (result_.fit) compare();
    return result_;
  }

 private:
  std::vector<ErrorVector> hypothesesFor(const Stretch& window) const {
    if (!config_.search_errors) return {ErrorVector::Zero()};
    double turn_rad = 0.0;
    for (std::size_t i = window.begin; i < window.end; ++i) {
      turn_rad += observations_[i].motion.rotation_rad;
    }
    return errorHypotheses(config_.batch.errors, turn_rad);
  }

  /// The best few hypotheses on one stretch of the record.
  void considerAll(const Stretch& window) {
    constexpr std::size_t kMostRefined = 3;
    constexpr std::uint32_t kSeed = 1;  // of the random draws: the same record, the same answer
    struct Start {
      ErrorVector errors;
      FixedPathFit fit;
    };
    std::vector<Start> starts;
    const std::vector<ErrorVector> hypotheses = hypothesesFor(window);
    for (const ErrorVector& errors : hypotheses) {
      const FixedPathFit fit =
          findConsensus(poseWithout(observations_, errors), window, kSeed, hypotheses.size() > 1);
      if (!fit.state_at_first.isZero()) starts.push_back({errors, fit});
    }
    std::sort(starts.begin(), starts.end(),
              [](const Start& a, const Start& b) { return a.fit.capped_cost < b.fit.capped_cost; });
    if (starts.size() > kMostRefined) starts.resize(kMostRefined);
    for (const Start& start : starts) {
      BatchEstimate batch =
          refine(observations_, start.fit.state_at_first, window.middle(), start.errors, config_);
      if (batch.last.empty() || !batch.last.mean.allFinite()) continue;
      if (!result_.fit || batch.cost < result_.fit->cost) result_.fit = std::move(batch);
    }
  }

  /// Takes the best of all minima, with the next one as its rival.
  void compare() {
    std::vector<OtherAnswer> others = findOtherAnswers(observations_, *result_.fit, config_);
    result_.rival.minima = kYawsAround;
    double ahead = 0.0;  // of what was found
    if (!others.empty() && others.front().gap < 0.0) {
      ahead = others.front().gap;
      result_.rival.offer(-ahead, result_.fit->last.mount().mean);
      result_.fit = std::move(others.front().fit);
      others.erase(others.begin());
    }
    for (const OtherAnswer& other : others) {
      result_.rival.offer(other.fit ? other.gap - ahead : other.gap, other.mount);
    }
  }

  std::vector<Observation> observations_;
  const InitializerConfig& config_;
  Answer result_;
};

/// None where not even its first pass is finite.
std::optional<BatchEstimate> fitFrom(const RecordStart& start,
                                     const std::vector<Observation>& observations,
                                     const InitializerConfig& config) {
  BatchEstimate fit = BatchEstimator(config.batch).estimate(observations, start);
  if (fit.path.points.empty()) return std::nullopt;
  return fit;
}

Answer findAnswer(const std::vector<Observation>& observations, const InitializerConfig& config) {
  Answer answer = Search(observations, config).run();  // of the thinned record
  if (!answer.fit) return {};
  answer.fit = fitFrom({answer.fit->last, observations.size() - 1}, observations, config);
  return answer;
}

/// Whether a search with the one would find what one with the other does.
bool areAlike(const NoiseLevels& a, const NoiseLevels& b) {
  constexpr double kBearingFactor = 1.3;
  constexpr double kWheelFactor = 3.0;
  return std::abs(std::log(a.bearing.value / b.bearing.value)) < std::log(kBearingFactor) &&
         std::abs(std::log(a.wheel.value / b.wheel.value)) < std::log(kWheelFactor);
}

void describe(const StateEstimate& estimate, StartAttempt* attempt) {
  attempt->estimate = estimate;
  attempt->weakest = weakestDirection(estimate.cartesian());
}

void describe(const Answer& answer, StartAttempt* attempt) {
  const BatchEstimate& fit = *answer.fit;
  attempt->chi_square = fit.chi_square;
  attempt->degrees_of_freedom = fit.degrees_of_freedom;
  attempt->rival = answer.rival;
  attempt->bearing_correlation = fit.correlation;
}

}  // namespace

void InitializerConfig::declare(Parameters& params) {
  params.between("initialisation/min_inlier_fraction", min_inlier_fraction, 0.0, 1.0);
  record.declare(params);
  batch.declare(params);
  noise.declare(params);
}

StartAttempt findStart(const std::vector<Observation>& observations,
                       const InitializerConfig& config, const NoiseLevels& noise_before) {
  StartAttempt attempt;
  attempt.motion = summariseMotion(observations);
  attempt.obstacle = motionObstacle(observations.size(), attempt.motion);
  if (attempt.obstacle != StartObstacle::kNone) return attempt;

  constexpr int kMostSearches = 3;
  attempt.noise = noise_before;
  std::vector<Observation> weighed = withNoise(observations, attempt.noise);
  Answer answer = findAnswer(weighed, config);
  std::optional<NoiseReview> review;
  for (int searches = 1; answer.fit && config.noise.any(); ++searches) {
    review = reviewNoise(observations, *answer.fit, config.batch.errors, config.noise,
                         unknownsWith(attempt.noise));
    if (!review) {
      answer.fit.reset();
      break;
    }
    const bool is_found = areAlike(review->levels, attempt.noise) || searches == kMostSearches;
    attempt.noise = review->levels;
    attempt.noise_cost = review->cost;
    weighed = withNoise(observations, attempt.noise);
    if (is_found) {
      answer.fit = fitFrom(surestStart(*answer.fit), weighed, config);
      break;
    }
    answer = findAnswer(weighed, config);
  }
  attempt.obstacle = StartObstacle::kNoSolution;
  if (!answer.fit) return attempt;
  const auto reviewed = [&](const StateEstimate& estimate) {
    return review ? changedAs(estimate, answer.fit->last, review->average) : estimate;
  };
  describe(answer, &attempt);
  describe(reviewed(answer.fit->last), &attempt);
  attempt.obstacle = answerObstacle(attempt, *answer.fit, config);
  if (!attempt.ready()) return attempt;
  describe(reviewed(averageOverSlips(weighed, *answer.fit, config.batch).estimate), &attempt);
  attempt.obstacle = answerObstacle(attempt, *answer.fit, config);
  return attempt;
}

NoiseLevels noiseToBeginWith(const std::vector<Observation>& observations,
                             const NoisePriors& priors) {
  NoiseLevels noise;
  constexpr double kMostSigmas = 2.0;
  const double limit = kMostSigmas * priors.bearing_stddev;
  if (limit > 0.0) {
    const double level = bearingLevelFromDifferences(observations);
    noise.bearing.value = std::clamp(level, std::exp(-limit), std::exp(limit));
  }
  return noise;
}

Initializer::Initializer(const InitializerConfig& config)
    : config_(validated(config)), record_(config.record) {}

}  // namespace bearing_calibration::core
