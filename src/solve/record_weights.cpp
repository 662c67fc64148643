#include "bearing_calibration/solve/record_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/filter/robust_loss.h"

namespace bearing_calibration::core {
namespace {

/// Rejections may change so often before they are frozen: observations at the very limit could go
/// in and out for ever.
constexpr int kMaxRejectionRounds = 6;
/// What a long motion can lower a slip's cost to: chance alone gains it once in ninety motions.
constexpr double kLeastSlipCost = 9.0;
/// Gain from which a fit gives up a motion by itself, however long. The more a robot is unlike its
/// model, the more often a large gain is no slip.
constexpr double kLeastOwnGain = 16.0;

/// Lag-1 correlation of standardised innovations, over those that follow each other; 0 where it is
/// insignificant.
class LagCorrelation {
 public:
  void add(const Innovation& innovation) {
    // Clipped, so that neither a slip's after-effects nor an outlier decide.
    constexpr double kClip = 2.5;
    const double standardised =
        std::clamp(innovation.residual / std::sqrt(innovation.variance), -kClip, kClip);
    if (has_last_) {
      products_ += last_ * standardised;
      squares_ += standardised * standardised;
      ++pairs_;
    }
    last_ = standardised;
    has_last_ = true;
  }
  void interrupt() { has_last_ = false; }

  double value() const {
    constexpr double kSignificant = 2.0;  // standard deviations, 1/sqrt(n) each, of white ones
    constexpr double kLargest = 0.9;  // beyond it the observations say nothing about their number
    if (pairs_ == 0 || squares_ <= 0.0) return 0.0;
    const double correlation = products_ / squares_;
    return correlation > kSignificant / std::sqrt(pairs_) ? std::min(correlation, kLargest) : 0.0;
  }

 private:
  double products_ = 0.0;
  double squares_ = 0.0;
  int pairs_ = 0;
  double last_ = 0.0;
  bool has_last_ = false;
};

/// Where the image after that of each observation begins.
std::vector<std::size_t> nextImages(const std::vector<Observation>& observations) {
  std::vector<std::size_t> next(observations.size(), observations.size());
  for (std::size_t i = observations.size(); i-- > 1;) {
    next[i - 1] = beginsImage(observations, i) ? i : next[i];
  }
  return next;
}

/// Lag-1 correlation of the standardised innovations of each light's observations in use; 0 where
/// insignificant.
/// @param innovation  of an observation; none where it is not in use
template <class Innovations>
std::array<double, kMostLights> correlations(const std::vector<Observation>& observations,
                                             const Innovations& innovation) {
  std::array<LagCorrelation, kMostLights> correlations;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    LagCorrelation& correlation = correlations.at(static_cast<std::size_t>(observations[i].light));
    if (const std::optional<Innovation> value = innovation(i)) {
      correlation.add(*value);
    } else {
      correlation.interrupt();
    }
  }
  std::array<double, kMostLights> values{};
  std::transform(correlations.begin(), correlations.end(), values.begin(),
                 [](const LagCorrelation& correlation) { return correlation.value(); });
  return values;
}

}  // namespace

double usualInterval(const std::vector<Observation>& observations) {
  std::vector<double> intervals_s;
  intervals_s.reserve(observations.size());
  for (std::size_t i = 1; i < observations.size(); ++i) {
    if (!beginsImage(observations, i)) continue;
    intervals_s.push_back(secondsBetween(observations[i - 1], observations[i]));
  }
  return intervals_s.empty() ? 0.0 : medianOf(std::move(intervals_s));
}

bool isNearSlip(Stamp moment, Stamp slip) {
  constexpr Duration kReach = std::chrono::milliseconds(250);
  return (moment < slip ? slip - moment : moment - slip) <= kReach;
}

RecordWeights::RecordWeights(const std::vector<Observation>& observations,
                             const std::vector<bool>& is_plausible, const BatchConfig& config,
                             const SlipHypothesis& slips)
    : records_(observations),
      config_(config),
      usual_interval_s_(usualInterval(observations)),
      next_image_(nextImages(observations)),
      supposed_(slips),
      huber_(config.huber_sigmas > 0.0) {
  widening_.fill(1.0);
  elevation_widening_.fill(1.0);
  const bool may_reject = config.reject_sigmas > 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double variance = observations[i].azimuth_variance_rad2;
    weights_.push_back({variance, variance, is_plausible[i] || !may_reject});
  }
  for (std::size_t slip : slips.given_up) giveUp(slip);
}

double RecordWeights::azimuthVariance(std::size_t i, const RecordPath& path) const {
  const auto light = static_cast<std::size_t>(records_[i].light);
  return widening_.at(light) * azimuthVarianceAt(records_[i], path.rangeAt(i, records_[i].light));
}

double RecordWeights::sigmas(std::size_t i, const RecordPath& path) const {
  const double residual = residualOf(records_[i], path.state(i, records_[i].light), path.errors);
  return std::abs(residual) / std::sqrt(azimuthVariance(i, path));
}

/// 0 where there is none, or none is asked for.
double RecordWeights::elevationSigmas(std::size_t i, const RecordPath& path) const {
  if (!config_.errors.usesElevations() || !records_[i].elevation) return 0.0;
  const Observation& observation = records_[i];
  const double widening = elevation_widening_.at(static_cast<std::size_t>(observation.light));
  const double residual =
      *elevationResidualOf(observation, path.state(i, observation.light), path.errors);
  return std::abs(residual) / std::sqrt(widening * observation.elevation->variance_rad2);
}

void RecordWeights::weighBearings(const RecordPath& path) {
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const double variance = azimuthVariance(i, path);
    const double doubt = huber_ ? huber(sigmas(i, path), config_.huber_sigmas).doubt : 1.0;
    weights_[i].sensor_variance_rad2 = variance;
    weights_[i].bearing_variance_rad2 = variance * doubt;
    weights_[i].elevation_widening =
        elevation_widening_.at(static_cast<std::size_t>(records_[i].light));
    weights_[i].elevation_doubt = huber(elevationSigmas(i, path), kElevationHuberSigmas).doubt;
  }
}

void RecordWeights::endHuber(const RecordPath& path) {
  huber_ = false;
  weighBearings(path);
}

bool RecordWeights::rejectOutliers(const SmootherPass& pass) {
  if (++rejection_rounds_ > kMaxRejectionRounds) return false;
  bool changed = false;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const SmoothedObservation& observation = pass.observations[i];
    const double range_m = pass.path.rangeAt(i, records_[i].light);
    const double variance =
        observation.left_out_variance_rad2 + azimuthVarianceAt(records_[i], range_m);
    const double limit = config_.reject_sigmas * config_.reject_sigmas * variance;
    const bool use = !isInsideSlip(i) &&
                     observation.left_out_residual_rad * observation.left_out_residual_rad <= limit;
    changed = changed || use != weights_[i].use_bearing;
    weights_[i].use_bearing = use;
  }
  return changed;
}

bool RecordWeights::isNear(std::size_t i, std::size_t slip) const {
  return isNearSlip(records_[i].stamp, records_[slip].stamp);
}

void RecordWeights::giveUp(std::size_t slip) {
  slips_.push_back(slip);
  for (std::size_t i = next_image_.front(); i < weights_.size(); ++i) {
    if (isNear(i, slip)) weights_[i].slipped = true;
  }
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (isInsideSlip(i)) weights_[i].use_bearing = false;
  }
}

/// A wheel slips at any time with the same probability: while the light is hidden for forty
/// times the usual interval, forty times more probably. (Twice a logarithm, as all costs are.)
double RecordWeights::slipCost(std::size_t i) const {
  if (i == 0 || usual_interval_s_ <= 0.0) return config_.slip_gain;
  const double intervals =
      std::max(1.0, secondsBetween(records_[i - 1], records_[i]) / usual_interval_s_);
  const double least = std::min(kLeastSlipCost, config_.slip_gain);
  return std::max(least, config_.slip_gain - 2.0 * std::log(intervals));
}

bool RecordWeights::giveUpSlip(const SmootherPass& pass) {
  const auto all = static_cast<int>(slips_.size());
  const auto further = all - static_cast<int>(supposed_.given_up.size());
  constexpr int kMostSlips = 20;
  const bool may_slip =
      config_.slip_gain > 0.0 && all < kMostSlips && further < supposed_.most_further;
  if (!may_slip) return false;
  std::size_t worst = 0;  // the record's first motion is not used
  double most_profit = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < weights_.size(); ++i) {
    const double profit = pass.observations[i].slip_gain - slipCost(i);
    if (weights_[i].slipped || profit <= most_profit) continue;
    const bool trusted = std::any_of(supposed_.trusted.begin(), supposed_.trusted.end(),
                                     [&](std::size_t slip) { return isNear(i, slip); });
    if (trusted) continue;
    worst = i;
    most_profit = profit;
  }
  if (worst == 0) return false;
  const double gain = pass.observations[worst].slip_gain;
  const bool is_enough = supposed_.least_gain > 0.0 ? gain >= supposed_.least_gain
                         : supposed_.at_its_cost    ? most_profit >= 0.0
                                                    : most_profit >= 0.0 && gain >= kLeastOwnGain;
  if (!is_enough) return false;
  giveUp(worst);
  return true;
}

/// An observation between two motions that are not believed only says where the light was at that
/// moment.
bool RecordWeights::isInsideSlip(std::size_t i) const {
  const std::size_t next = next_image_[i];
  return weights_[i].slipped && next < weights_.size() && weights_[next].slipped;
}

bool RecordWeights::widenForCorrelation(const SmootherPass& pass, const RecordPath& path) {
  auto azimuths = correlations(records_, [&](std::size_t i) -> std::optional<Innovation> {
    if (!weights_[i].use_bearing) return std::nullopt;
    return pass.observations[i].azimuth;
  });
  const auto elevations =
      correlations(records_, [&](std::size_t i) { return pass.observations[i].elevation; });
  if (config_.correlation) azimuths.fill(*config_.correlation);
  correlation_ = *std::max_element(azimuths.begin(), azimuths.end());
  std::transform(azimuths.begin(), azimuths.end(), widening_.begin(), wideningFor);
  std::transform(elevations.begin(), elevations.end(), elevation_widening_.begin(), wideningFor);
  weighBearings(path);
  const auto isWider = [](double widening) { return widening > 1.0; };
  return std::any_of(widening_.begin(), widening_.end(), isWider) ||
         std::any_of(elevation_widening_.begin(), elevation_widening_.end(), isWider);
}

double RecordWeights::bearingCost(const RecordPath& path) const {
  double cost = 0.0;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (!weights_[i].use_bearing) continue;
    const double size = sigmas(i, path);
    cost += huber_ ? huber(size, config_.huber_sigmas).cost : size * size;
    cost += huber(elevationSigmas(i, path), kElevationHuberSigmas).cost;
    // a path near the light must not gain by the variance that it makes larger
    if (records_[i].light_size_m > 0.0) {
      cost += std::log(azimuthVarianceAt(records_[i], path.rangeAt(i, records_[i].light)) /
                       records_[i].azimuth_variance_rad2);
    }
  }
  return cost;
}

double RecordWeights::costOfDisbelief(const RecordPath& path) const {
  const double cost_of_outlier = config_.reject_sigmas * config_.reject_sigmas;
  double cost = 0.0;
  for (std::size_t slip : slips_) cost += slipCost(slip);
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (weights_[i].use_bearing) continue;
    // A slip must not gain by the outliers that it happens to hide: a bearing in use costs 1 on the
    // average, and so does one inside a slip that may be the light's.
    cost += isInsideSlip(i) && mayBeLight(i, path) ? 1.0 : cost_of_outlier;
  }
  return cost;
}

/// Whether an observation inside a slip is as near to where the light is seen before and after as a
/// slip leaves it.
bool RecordWeights::mayBeLight(std::size_t i, const RecordPath& path) const {
  constexpr double kMostTurn_rad = 0.5;
  const Vector5 state = path.state(i, records_[i].light);
  return std::abs(residualOf(records_[i], state, path.errors)) < kMostTurn_rad;
}

double wideningFor(double correlation) { return (1.0 + correlation) / (1.0 - correlation); }

}  // namespace bearing_calibration::core
