#include "bearing_calibration/solve/noise_levels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/solve/record_weights.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {
namespace {

/// Bearing and wheel factor, as natural logarithms.
using Logs = Eigen::Vector2d;

NoiseLevels levelsOf(const Logs& logs, const Logs& stddev) {
  return {{std::exp(logs(0)), stddev(0)}, {std::exp(logs(1)), stddev(1)}};
}

/// How likely a record's innovations are, by the logarithms of the factors.
class Likelihood {
 public:
  Likelihood(const std::vector<Observation>& observations, const BatchEstimate& fit,
             const ErrorPriors& errors, const NoisePriors& priors)
      : observations_(observations),
        errors_(errors),
        known_(fit.known()),
        path_(fit.path),
        prior_stddev_(priors.bearing_stddev, priors.wheel_stddev) {
    weights_.resize(observations.size());
    for (std::size_t i : fit.rejected) weights_[i].use_bearing = false;
    for (std::size_t slip : fit.slips) {
      for (std::size_t i = 1; i < observations.size(); ++i) {
        if (isNearSlip(observations[i].stamp, observations[slip].stamp)) weights_[i].slipped = true;
      }
    }
  }

  bool looksFor(int factor) const { return prior_stddev_(factor) > 0.0; }
  double priorStddev(int factor) const { return prior_stddev_(factor); }

  /// Minus its logarithm.
  double cost(const Logs& logs) const {
    endIfCancelled();
    const std::vector<Observation> scaled = withNoise(observations_, levelsOf(logs, Logs::Zero()));
    std::vector<ObservationWeight> weights = weights_;
    for (std::size_t i = 0; i < scaled.size(); ++i) {
      weights[i].sensor_variance_rad2 = scaled[i].azimuth_variance_rad2;
      weights[i].bearing_variance_rad2 = scaled[i].azimuth_variance_rad2;
    }
    const SmootherPass pass = smooth(scaled, weights, path_, kFreePass, errors_, known_);
    double cost = 0.0;
    for (std::size_t i = 0; i < scaled.size(); ++i) {
      if (!weights[i].use_bearing) continue;
      const SmoothedObservation& observation = pass.observations[i];
      cost += 0.5 * (std::log(observation.innovation_variance_rad2) +
                     observation.innovation_rad * observation.innovation_rad /
                         observation.innovation_variance_rad2);
    }
    for (int factor = 0; factor < 2; ++factor) {
      if (looksFor(factor)) cost += 0.5 * std::pow(logs(factor) / prior_stddev_(factor), 2);
    }
    return cost;
  }

 private:
  const std::vector<Observation>& observations_;
  const ErrorPriors& errors_;
  const LightsEstimate* known_;  ///< at the record's beginning
  RecordPath path_;
  std::vector<ObservationWeight> weights_;
  Eigen::Vector2d prior_stddev_;
};

/// Gradient and curvature by differences; of a factor that is not looked for, none.
struct Shape {
  Logs gradient = Logs::Zero();
  Eigen::Matrix2d curvature = Eigen::Matrix2d::Identity();
};

Shape shapeAt(const Likelihood& likelihood, const Logs& logs) {
  constexpr double kStep = 0.1;
  const auto costAt = [&](double bearing, double wheel) {
    return likelihood.cost(logs + kStep * Logs(bearing, wheel));
  };
  Shape shape;
  const double here = costAt(0.0, 0.0);
  for (int factor = 0; factor < 2; ++factor) {
    if (!likelihood.looksFor(factor)) continue;
    const Logs way = Logs::Unit(factor);
    const double more = costAt(way(0), way(1));
    const double less = costAt(-way(0), -way(1));
    shape.gradient(factor) = (more - less) / (2.0 * kStep);
    shape.curvature(factor, factor) = (more - 2.0 * here + less) / (kStep * kStep);
  }
  if (likelihood.looksFor(0) && likelihood.looksFor(1)) {
    const double mixed =
        costAt(1.0, 1.0) - costAt(1.0, -1.0) - costAt(-1.0, 1.0) + costAt(-1.0, -1.0);
    shape.curvature(0, 1) = shape.curvature(1, 0) = mixed / (4.0 * kStep * kStep);
  }
  // Far from the maximum it may bend the wrong way: there it is held to the prior's curvature.
  for (int factor = 0; factor < 2; ++factor) {
    if (!likelihood.looksFor(factor)) continue;
    const double prior = 1.0 / std::pow(likelihood.priorStddev(factor), 2);
    shape.curvature(factor, factor) = std::max(shape.curvature(factor, factor), prior);
  }
  if (!(shape.curvature.determinant() > 0.0)) {
    shape.curvature = Eigen::Matrix2d(shape.curvature.diagonal().asDiagonal());
  }
  return shape;
}

}  // namespace

std::vector<std::string> NoisePriors::validate() const {
  Requirements require;
  constexpr double kLargest = 10.0;  // of a logarithm: a factor of 22000
  require.between("errors/bearing_noise_stddev", bearing_stddev, 0.0, kLargest);
  require.between("errors/wheel_noise_stddev", wheel_stddev, 0.0, kLargest);
  return require.errors();
}

NoiseLevels findNoiseLevels(const std::vector<Observation>& observations, const BatchEstimate& fit,
                            const ErrorPriors& errors, const NoisePriors& priors) {
  const Likelihood likelihood(observations, fit, errors, priors);
  constexpr int kMostSteps = 12;
  constexpr double kLongestStep = 0.7;  // a factor of two
  constexpr double kSettled = 0.02;
  // Far from its own maximum, too small a noise of the bearings looks like one of the wheels: the
  // bearings' factor, which many more numbers tell, goes first.
  bool bearings_alone = likelihood.looksFor(0);
  Logs logs = Logs::Zero();
  Shape shape;
  for (int i = 0; i < kMostSteps; ++i) {
    shape = shapeAt(likelihood, logs);
    const Logs step = bearings_alone ? Logs(-shape.gradient(0) / shape.curvature(0, 0), 0.0)
                                     : Logs(-(shape.curvature.inverse() * shape.gradient));
    logs += step.cwiseMax(-kLongestStep).cwiseMin(kLongestStep);
    const bool is_settled = step.cwiseAbs().maxCoeff() < kSettled;
    if (is_settled && !bearings_alone) break;
    if (step.cwiseAbs().maxCoeff() < kLongestStep) bearings_alone = false;
  }
  Logs stddev = shape.curvature.inverse().diagonal().cwiseSqrt();
  for (int factor = 0; factor < 2; ++factor) {
    if (!likelihood.looksFor(factor)) stddev(factor) = 0.0;
  }
  return levelsOf(logs, stddev);
}

std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const NoiseLevels& noise) {
  for (Observation& observation : observations) {
    observation.azimuth_variance_rad2 *= noise.bearing.value * noise.bearing.value;
    observation.motion = withNoise(observation.motion, noise);
  }
  return observations;
}

std::vector<Bearing> withNoise(std::vector<Bearing> bearings, const NoiseLevels& noise) {
  for (Bearing& bearing : bearings) {
    bearing.azimuth_variance_rad2 *= noise.bearing.value * noise.bearing.value;
  }
  return bearings;
}

OdometryIncrement withNoise(OdometryIncrement motion, const NoiseLevels& noise) {
  motion.covariance *= noise.wheel.value;
  return motion;
}

CorrelationTime correlationTime(const std::vector<Observation>& observations, double correlation) {
  if (!(correlation > 0.0) || observations.size() < 2) return {};
  std::vector<double> intervals_s;
  for (std::size_t i = 1; i < observations.size(); ++i) {
    intervals_s.push_back(secondsFromDuration(observations[i].stamp - observations[i - 1].stamp));
  }
  const auto middle = intervals_s.begin() + static_cast<std::ptrdiff_t>(intervals_s.size() / 2);
  std::nth_element(intervals_s.begin(), middle, intervals_s.end());
  const double log = std::log(correlation);
  const double correlation_stddev = 1.0 / std::sqrt(static_cast<double>(observations.size()));
  return {-*middle / log, *middle / (correlation * log * log) * correlation_stddev};
}

}  // namespace bearing_calibration::core
