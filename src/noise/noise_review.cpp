#include "bearing_calibration/noise/noise_review.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {
namespace {

/// Mean and covariance over the levels after so many observations, by two points of them for each
/// unknown.
StateEstimate averageOver(const NoiseRecord& record, const NoiseReview& review, std::size_t count) {
  constexpr int kPoints = 2 * kNoiseUnknowns;
  const SymmetricEigen axes = eigenOf(kNoiseUnknowns * review.covariance);
  const NoiseUnknownsMatrix root =
      axes.vectors * axes.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * axes.vectors.transpose();
  const auto filtered = [&](const NoiseUnknowns& unknowns) {
    return record.filter(unknowns, review.gives_up_slips, count).last;
  };
  const StateEstimate middle = filtered(review.likeliest);
  StateEstimate average = StateEstimate::zero(middle.layout);
  for (int i = 0; i < kPoints; ++i) {
    const double sign = i < kNoiseUnknowns ? 1.0 : -1.0;
    const StateEstimate point = filtered(review.likeliest + sign * root.col(i % kNoiseUnknowns));
    const StateVector off = point.mean - middle.mean;
    average.mean += off / kPoints;
    average.covariance += (point.covariance + off * off.transpose()) / kPoints;
  }
  average.covariance -= average.mean * average.mean.transpose();
  average.mean += middle.mean;
  return average;
}

/// Below it the bearings' level is not searched.
double leastBearingLevel(const std::vector<Observation>& observations, const ErrorPriors& errors) {
  /// Of how neighbours differ, which wheels hardly touch: else noise that lasts is laid to them.
  constexpr double kShareOfDifferences = 0.7;
  double stated_rad2 = 0.0;
  for (const Observation& observation : observations) {
    stated_rad2 += observation.azimuth_variance_rad2 / static_cast<double>(observations.size());
  }
  // What a mirror's law leaves out is no noise: no scatter shows it.
  return std::max(kShareOfDifferences * bearingLevelFromDifferences(observations),
                  errors.geometry().unmodelledStddev() / std::sqrt(stated_rad2));
}

/// The size of a light that would add to the bearings' variances as much as is stated.
double equalLightSize(const std::vector<Observation>& observations, const BatchEstimate& fit) {
  double variance_of_metre = 0.0;  // over the stated one
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double range_m = fit.path.rangeAt(i, observations[i].light);
    variance_of_metre += 1.0 / (range_m * range_m * observations[i].azimuth_variance_rad2);
  }
  return std::sqrt(static_cast<double>(observations.size()) / variance_of_metre);
}

}  // namespace

std::optional<NoiseReview> reviewNoise(const std::vector<Observation>& observations,
                                       const BatchEstimate& fit, const ErrorPriors& errors,
                                       const NoisePriors& priors, const NoiseUnknowns& start,
                                       const NoiseInformation& told_before) {
  constexpr double kCostOfSlip = 10.0;  // half the chi-square for which a fit gives a motion up
  const NoiseRecord record(observations, fit, errors);
  double least_log_bearing = start(kBearingLevel);
  NoiseUnknowns begin = start;
  begin(kLightSize) = -40.0;  // the logarithm of nothing
  if (priors.bearing_stddev > 0.0) {
    least_log_bearing = std::log(leastBearingLevel(observations, errors));
    // From above: where the light's size hardly matters, no step says that it does.
    const double half = 0.5 * std::exp(start(kBearingLevel)) * equalLightSize(observations, fit);
    begin(kLightSize) = std::max(start(kLightSize), std::log(half));
  }
  const auto findLevels = [&](bool gives_up_slips) {
    return findNoise(record, priors, told_before, least_log_bearing, gives_up_slips, begin);
  };
  bool gives_up_slips = true;
  LikeliestNoise likeliest = findLevels(gives_up_slips);
  if (!fit.slips.empty()) {
    const LikeliestNoise noisier = findLevels(false);
    const double cost = likeliest.cost + kCostOfSlip * static_cast<double>(fit.slips.size());
    if (noisier.cost < cost) {
      gives_up_slips = false;
      likeliest = noisier;
    }
  }
  const NoiseUnknowns stddev = likeliest.covariance.diagonal().cwiseSqrt();
  NoiseReview review{likeliest.unknowns,
                     likeliest.covariance,
                     {{std::exp(likeliest.unknowns(kBearingLevel)), stddev(kBearingLevel)},
                      {std::exp(likeliest.unknowns(kWheelLevel)), stddev(kWheelLevel)},
                      {std::exp(likeliest.unknowns(kLightSize)), stddev(kLightSize)}},
                     likeliest.cost,
                     gives_up_slips,
                     {},
                     likeliest.told};
  review.average = averageOver(record, review, record.size());
  const bool is_any = std::isfinite(review.cost) && review.average.mean.allFinite() &&
                      review.average.covariance.allFinite();
  return is_any ? std::optional(review) : std::nullopt;
}

StateEstimate averageAfter(std::size_t count, const std::vector<Observation>& observations,
                           const BatchEstimate& fit, const ErrorPriors& errors,
                           const NoiseReview& review) {
  return averageOver(NoiseRecord(observations, fit, errors), review, count);
}

}  // namespace bearing_calibration::core
