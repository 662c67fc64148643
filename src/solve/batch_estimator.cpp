#include "bearing_calibration/solve/batch_estimator.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/solve/batch_fit.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

BatchConfig BatchConfig::leastSquares(const ErrorPriors& errors) {
  BatchConfig config;
  config.huber_sigmas = 0.0;
  config.reject_sigmas = 0.0;
  config.slip_gain = 0.0;
  config.widen_for_correlation = false;
  config.errors = errors;
  return config;
}

BatchConfig BatchConfig::weighedAs(const BatchEstimate& fit) const {
  BatchConfig alike = *this;
  alike.correlation = fit.correlation;
  return alike;
}

void BatchConfig::declare(Parameters& params) {
  params.notNegative("batch/huber_sigmas", huber_sigmas);
  params.notNegative("batch/reject_sigmas", reject_sigmas);
  params.notNegative("batch/slip_gain", slip_gain);
  errors.declare(params);
}

bool BatchEstimate::hasSettled(double min_inlier_fraction) const {
  return converged &&
         1.0 - static_cast<double>(rejected.size()) / static_cast<double>(nis.size()) >=
             min_inlier_fraction;
}

Scatter BatchEstimate::scatter() const {
  Scatter all = beginning ? beginning->scatter : Scatter();
  all += scatterOf(mount_displacements, 0, mount_displacements.size());
  return all;
}

RecordStart surestStart(const BatchEstimate& fit) {
  std::size_t longest_begin = 0;
  std::size_t longest = 0;
  std::size_t begin = 0;
  const auto endStretch = [&](std::size_t end) {
    if (end - begin > longest) {
      longest_begin = begin;
      longest = end - begin;
    }
    begin = end;
  };
  for (std::size_t slip : fit.slips) endStretch(slip);
  endStretch(fit.path.points.size());
  const std::size_t observation = longest_begin + longest / 2;
  RecordStart start(fit.last, observation);
  start.mount = fit.path.mount;
  start.lights_in_base = fit.path.points[observation].lights_in_base;
  return start;
}

BatchEstimator::BatchEstimator(const BatchConfig& config) : config_(validated(config)) {}

BatchEstimate BatchEstimator::estimate(const std::vector<Observation>& observations,
                                       const RecordStart& start, const SlipHypothesis& slips,
                                       const std::optional<RecordBeginning>& beginning) const {
  if (start.observation >= observations.size()) {
    throw std::invalid_argument("the start of a batch estimate is not at one of its observations");
  }
  return estimate(observations, trackLights(observations, start), slips, beginning);
}

BatchEstimate BatchEstimator::estimate(const std::vector<Observation>& observations,
                                       const RecordTrack& track, const SlipHypothesis& slips,
                                       const std::optional<RecordBeginning>& beginning) const {
  const auto is_outside = [&observations](std::size_t i) { return i >= observations.size(); };
  if (observations.empty() || track.path.points.size() != observations.size() ||
      track.is_plausible.size() != observations.size() ||
      std::any_of(slips.given_up.begin(), slips.given_up.end(), is_outside) ||
      std::any_of(slips.trusted.begin(), slips.trusted.end(), is_outside)) {
    throw std::invalid_argument(
        "the track or a supposed slip of a batch estimate is not at one of its observations");
  }
  const int lights = track.path.lights();
  const StateLayout layout{errorsInUse(config_.errors, lights), lights};
  if (beginning && (beginning->known.layout.errors != layout.errors ||
                    beginning->known.layout.lights != layout.lights)) {
    throw std::invalid_argument(
        "the beginning of a batch estimate is not of its lights and the errors in use");
  }
  const auto expectPositive = [](const char* angle, double variance_rad2) {
    if (variance_rad2 > 0.0) return;
    throw std::invalid_argument(std::string(angle) + " variance " + std::to_string(variance_rad2) +
                                " rad^2 is not positive");
  };
  for (const Observation& observation : observations) {
    expectPositive("azimuth", observation.azimuth_variance_rad2);
    if (observation.elevation) expectPositive("elevation", observation.elevation->variance_rad2);
    if (observation.light < 0 || observation.light >= lights) {
      throw std::invalid_argument("light " + std::to_string(observation.light) +
                                  " is not on the track");
    }
  }
  return BatchFit(observations, track, config_, slips, beginning).run();
}

StateEstimate BatchEstimator::filteredAt(std::size_t observation,
                                         const std::vector<Observation>& observations,
                                         const BatchEstimate& fit) const {
  const auto until = [observation](const auto& all) {
    return std::vector(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(observation + 1));
  };
  const RecordPath path{until(fit.path.points), fit.path.mount, fit.path.errors};
  return smooth(until(observations), until(fit.weights), path, kFreePass, config_.errors,
                fit.known())
      .last;
}

StateEstimate BatchEstimator::knownAt(std::size_t observation,
                                      const std::vector<Observation>& observations,
                                      const BatchEstimate& fit,
                                      const std::optional<StateEstimate>& average) const {
  StateEstimate known = filteredAt(observation, observations, fit);
  if (average) known = changedAs(known, known, *average);
  return withoutLearntScale(known, fit.path.stateAt(known.layout, observation), config_.errors);
}

}  // namespace bearing_calibration::core
