#include "bearing_calibration/init/other_answers.h"

#include <algorithm>
#include <utility>

#include "bearing_calibration/init/closed_form.h"
#include "bearing_calibration/init/start_candidates.h"
#include "bearing_calibration/init/start_obstacle.h"

namespace bearing_calibration::core {

std::vector<PosedObservation> poseWithout(const std::vector<Observation>& observations,
                                          const ErrorVector& errors) {
  return poseObservations(errors.isZero(0.0) ? observations : withoutErrors(observations, errors));
}

BatchEstimate refine(const std::vector<Observation>& observations, const Vector5& state_at_first,
                     std::size_t observation, const ErrorVector& errors,
                     const InitializerConfig& config) {
  Vector5 state = stateAt(poseWithout(observations, errors)[observation], state_at_first);
  state.head<2>() =
      stampFromMoment(observations[observation], errors) * Eigen::Vector2d(state.head<2>());
  return BatchEstimator(config.batch).estimate(observations, {state, observation, errors});
}

namespace {

/// The Cartesian state at a record's first observation, without the robot's errors.
Vector5 stateAtFirst(const std::vector<Observation>& observations,
                     const std::vector<PosedObservation>& posed, const BatchEstimate& found,
                     const ErrorVector& errors) {
  Vector5 state = cartesianOf(found.last.layout, found.last.mean, 0);
  state.head<2>() =
      posed.back().first_from_base *
      (stampFromMoment(observations.back(), errors).inverse() * Eigen::Vector2d(state.head<2>()));
  return state;
}

}  // namespace

std::vector<OtherAnswer> findOtherAnswers(const std::vector<Observation>& all,
                                          const BatchEstimate& found,
                                          const InitializerConfig& config) {
  constexpr int kMostRefined = 3;
  const std::vector<Observation> observations = thinned(all, kObservationsOfSearch);
  const ErrorVector errors = robotErrorsOf(found.last.layout, found.last.mean);
  const std::vector<PosedObservation> posed = poseWithout(observations, errors);
  const FixedPathWeight weight{posed.size() / 2};
  InitializerConfig alike = config;
  alike.batch = config.batch.weighedAs(found);
  const auto fitFrom = [&](const Vector5& state_at_first) {
    return refine(observations, state_at_first, weight.reference, errors, alike);
  };
  const Vector5 first = stateAtFirst(observations, posed, found, errors);
  // fitted again, as the others are, to the path that the odometry alone gives
  const double found_cost = fitOnFixedPath(posed, first, weight).cost;
  const double within_m = sameMountWithin(summariseMotion(observations).extent_m);
  std::optional<double> cost;  // of what was found, on these observations
  if (observations.size() == all.size()) cost = found.cost;
  std::vector<Vector5> refined = {found.last.cartesian().mean};
  std::vector<OtherAnswer> answers;
  for (const FixedPathFit& other : findOtherMinima(posed, first, within_m)) {
    const double margin = other.cost - found_cost;
    if (margin >= StartLimits::kMinRunnerUpMargin || refined.size() > kMostRefined) {
      answers.push_back(
          {0.5 * std::max(0.0, margin), other.state_at_first.tail<3>(), std::nullopt});
      continue;
    }
    BatchEstimate batch = fitFrom(other.state_at_first);
    if (batch.last.empty()) continue;
    const Vector5 state = batch.last.cartesian().mean;
    const bool is_known = std::any_of(refined.begin(), refined.end(), [&](const Vector5& known) {
      return isSameMount(known, state, within_m);
    });
    refined.push_back(state);
    if (is_known) continue;
    if (!cost) {
      const RecordStart last{refined.front(), observations.size() - 1, errors};
      cost = BatchEstimator(alike.batch).estimate(observations, last).cost;
    }
    answers.push_back({0.5 * (batch.cost - *cost), state.tail<3>(), std::move(batch)});
  }
  std::sort(answers.begin(), answers.end(),
            [](const OtherAnswer& a, const OtherAnswer& b) { return a.gap < b.gap; });
  return answers;
}

}  // namespace bearing_calibration::core
