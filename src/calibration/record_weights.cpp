#include "bearing_calibration/calibration/record_weights.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration {
namespace {

/// Rejections may change so often before they are frozen: sights at the very limit could go in and
/// out for ever.
constexpr int kMaxRejectionRounds = 6;
/// A slip lasts: what is found is its most telling moment, and motions this near are not believed
/// either.
constexpr Duration kSlipReach = std::chrono::milliseconds(250);

}  // namespace

RecordWeights::RecordWeights(const std::vector<Sight>& sights,
                             const std::vector<bool>& is_plausible, const BatchConfig& config,
                             const SlipHypothesis& slips)
    : records_(sights), config_(config), supposed_(slips), huber_(config.huber_sigmas > 0.0) {
  const bool may_reject = config.reject_sigmas > 0.0;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const double variance = sights[i].azimuth_variance_rad2;
    weights_.push_back({variance, variance, is_plausible[i] || !may_reject});
  }
  for (std::size_t slip : slips.given_up) giveUp(slip);
}

double RecordWeights::sigmas(std::size_t i, const RecordPath& path) const {
  const double residual = residualOf(records_[i], path.points[i].state, path.errors);
  return std::abs(residual) / std::sqrt(widening_ * records_[i].azimuth_variance_rad2);
}

void RecordWeights::weighBearings(const RecordPath& path) {
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    const double variance = widening_ * records_[i].azimuth_variance_rad2;
    const double doubt = huber_ ? std::max(1.0, sigmas(i, path) / config_.huber_sigmas) : 1.0;
    weights_[i].sensor_variance_rad2 = variance;
    weights_[i].bearing_variance_rad2 = variance * doubt;
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
    const SmoothedSight& sight = pass.sights[i];
    const double variance = sight.left_out_variance_rad2 + records_[i].azimuth_variance_rad2;
    const double limit = config_.reject_sigmas * config_.reject_sigmas * variance;
    const bool use =
        !isInsideSlip(i) && sight.left_out_residual_rad * sight.left_out_residual_rad <= limit;
    changed = changed || use != weights_[i].use_bearing;
    weights_[i].use_bearing = use;
  }
  return changed;
}

bool RecordWeights::isNear(std::size_t i, std::size_t slip) const {
  const Duration apart = records_[i].stamp - records_[slip].stamp;
  return (apart < Duration::zero() ? -apart : apart) <= kSlipReach;
}

void RecordWeights::giveUp(std::size_t slip) {
  slips_.push_back(slip);
  for (std::size_t i = 1; i < weights_.size(); ++i) {
    if (isNear(i, slip)) weights_[i].slipped = true;
  }
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (isInsideSlip(i)) weights_[i].use_bearing = false;
  }
}

bool RecordWeights::giveUpSlip(const SmootherPass& pass) {
  const auto all = static_cast<int>(slips_.size());
  const auto further = all - static_cast<int>(supposed_.given_up.size());
  const bool may_slip =
      config_.slip_gain > 0.0 && all < config_.max_slips && further < supposed_.most_further;
  if (!may_slip) return false;
  const double least = supposed_.least_gain > 0.0 ? supposed_.least_gain : config_.slip_gain;
  std::size_t worst = 0;  // the record's first motion is not used
  for (std::size_t i = 1; i < weights_.size(); ++i) {
    if (pass.sights[i].slip_gain <= pass.sights[worst].slip_gain) continue;
    const bool trusted = std::any_of(supposed_.trusted.begin(), supposed_.trusted.end(),
                                     [&](std::size_t slip) { return isNear(i, slip); });
    if (!trusted) worst = i;
  }
  if (pass.sights[worst].slip_gain < least) return false;
  giveUp(worst);
  return true;
}

/// A sight between two motions that are not believed only says where the light was at that moment.
bool RecordWeights::isInsideSlip(std::size_t i) const {
  return weights_[i].slipped && i + 1 < weights_.size() && weights_[i + 1].slipped;
}

bool RecordWeights::widenForCorrelation(const SmootherPass& pass, const RecordPath& path) {
  correlation_ = innovationCorrelation(pass, weights_);
  // n bearings whose noise is a first-order autoregression are worth this times fewer white ones.
  widening_ = (1.0 + correlation_) / (1.0 - correlation_);
  weighBearings(path);
  return correlation_ > 0.0;
}

double RecordWeights::bearingCost(const RecordPath& path) const {
  double cost = 0.0;
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (!weights_[i].use_bearing) continue;
    const double size = sigmas(i, path);
    cost += huber_ && size > config_.huber_sigmas
                ? config_.huber_sigmas * (2.0 * size - config_.huber_sigmas)
                : size * size;
  }
  return cost;
}

double RecordWeights::costOfDisbelief(const RecordPath& path) const {
  const double cost_of_outlier = config_.reject_sigmas * config_.reject_sigmas;
  double cost = config_.slip_gain * static_cast<double>(slips_.size());
  for (std::size_t i = 0; i < weights_.size(); ++i) {
    if (weights_[i].use_bearing) continue;
    // A slip must not gain by the outliers that it happens to hide: a bearing in use costs 1 on the
    // average, and so does one inside a slip that may be the light's.
    cost += isInsideSlip(i) && mayBeLight(i, path) ? 1.0 : cost_of_outlier;
  }
  return cost;
}

/// Whether a sight inside a slip is as near to where the light is seen before and after as a slip
/// leaves it.
bool RecordWeights::mayBeLight(std::size_t i, const RecordPath& path) const {
  constexpr double kMostTurn_rad = 0.5;
  return std::abs(residualOf(records_[i], path.points[i].state, path.errors)) < kMostTurn_rad;
}

double innovationCorrelation(const SmootherPass& pass, const std::vector<SightWeight>& weights) {
  // Clipped, so that neither a slip's after-effects nor an outlier decide.
  constexpr double kClip = 2.5;
  constexpr double kSignificant = 2.0;  // standard deviations, 1/sqrt(n) each, of white innovations
  constexpr double kLargest = 0.9;      // beyond it the sights say nothing about their number
  double products = 0.0;
  double squares = 0.0;
  int pairs = 0;
  double last = 0.0;
  bool has_last = false;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (!weights[i].use_bearing) {
      has_last = false;
      continue;
    }
    const SmoothedSight& sight = pass.sights[i];
    const double standardised =
        std::clamp(sight.innovation_rad / std::sqrt(sight.innovation_variance_rad2), -kClip, kClip);
    if (has_last) {
      products += last * standardised;
      squares += standardised * standardised;
      ++pairs;
    }
    last = standardised;
    has_last = true;
  }
  if (pairs == 0 || squares <= 0.0) return 0.0;
  const double correlation = products / squares;
  return correlation > kSignificant / std::sqrt(pairs) ? std::min(correlation, kLargest) : 0.0;
}

}  // namespace bearing_calibration
