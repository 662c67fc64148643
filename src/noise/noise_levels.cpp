#include "bearing_calibration/noise/noise_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {

NoiseLevels NoiseLevels::atMost() const {
  constexpr double kSigmas = 2.0;
  const auto above = [](const NoiseFactor& factor) {
    return NoiseFactor{factor.value * std::exp(kSigmas * factor.log_stddev), factor.log_stddev};
  };
  const double size_m = light_size.stddev_m * std::exp(kSigmas * light_size.log_stddev);
  return {above(bearing), above(wheel), {size_m, light_size.log_stddev}};
}

NoiseLevels NoiseLevels::widenedFor(double bearing_correlation) const {
  const double widening = std::sqrt(wideningFor(bearing_correlation));
  NoiseLevels widened = *this;
  widened.bearing.value *= widening;
  widened.light_size.stddev_m *= widening;
  return widened;
}

double NoiseLevels::varianceOver(const NoiseLevels& others) const {
  return std::max(std::pow(bearing.value / others.bearing.value, 2),
                  wheel.value / others.wheel.value);
}

NoiseLevels atMost(NoiseLevels levels, const NoiseLevels& limit) {
  levels.bearing.value = std::min(levels.bearing.value, limit.bearing.value);
  levels.wheel.value = std::min(levels.wheel.value, limit.wheel.value);
  levels.light_size.stddev_m = std::min(levels.light_size.stddev_m, limit.light_size.stddev_m);
  return levels;
}

bool NoisePriors::isSurprisedBy(const NoiseLevels& levels) const {
  constexpr double kSurprisingSigmas = 1.5;
  const auto isFar = [](double factor, double stddev) {
    return std::log(factor) > kSurprisingSigmas * stddev;
  };
  return (bearing_stddev > 0.0 && isFar(levels.bearing.value, bearing_stddev)) ||
         (wheel_stddev > 0.0 && isFar(levels.wheel.value, wheel_stddev));
}

void NoisePriors::declare(Parameters& params) {
  constexpr double kLargest = 10.0;  // of a logarithm: a factor of 22000
  params.number("errors/bearing_noise_stddev", bearing_stddev, 0.0, kLargest);
  params.number("errors/wheel_noise_stddev", wheel_stddev, 0.0, kLargest);
}

CorrelationTime correlationTime(const std::vector<Observation>& observations, double correlation) {
  if (!(correlation > 0.0) || observations.size() < 2) return {};
  const double interval_s = usualInterval(observations);
  const double log = std::log(correlation);
  const double correlation_stddev = 1.0 / std::sqrt(static_cast<double>(observations.size()));
  return {-interval_s / log, interval_s / (correlation * log * log) * correlation_stddev};
}

double bearingLevelFromDifferences(const std::vector<Observation>& observations) {
  constexpr std::size_t kFewest = 30;
  constexpr double kMostIntervals = 1.5;  // between neighbours
  constexpr double kVariance = 20.0;      // of a third difference of white noise
  const double longest_s = kMostIntervals * usualInterval(observations);
  std::vector<double> thirds;  // differences, over their stated standard deviations
  std::size_t neighbours = 0;  // so many changes of azimuth in a row, up to this observation
  double changes[3] = {};      // the last ones, without the base's turn
  for (std::size_t i = 1; i < observations.size(); ++i) {
    const Observation& now = observations[i];
    neighbours = secondsBetween(observations[i - 1], now) <= longest_s ? neighbours + 1 : 0;
    changes[0] = changes[1];
    changes[1] = changes[2];
    changes[2] = wrapAngle(now.azimuth_rad - observations[i - 1].azimuth_rad +
                           now.motion.start_from_end.yaw_rad);
    if (neighbours < 3) continue;
    const double third = wrapAngle(changes[2] - 2.0 * changes[1] + changes[0]);
    thirds.push_back(third / std::sqrt(kVariance * now.azimuth_variance_rad2));
  }
  return thirds.size() < kFewest ? 1.0 : robustStddev(std::move(thirds));
}

Observation withNoise(Observation observation, const NoiseLevels& noise) {
  observation.azimuth_variance_rad2 *= noise.bearing.value * noise.bearing.value;
  observation.light_size_m = noise.light_size.stddev_m;
  observation.motion = withNoise(observation.motion, noise);
  return observation;
}

std::vector<Observation> withNoise(std::vector<Observation> observations,
                                   const NoiseLevels& noise) {
  for (Observation& observation : observations) observation = withNoise(observation, noise);
  return observations;
}

Bearing withNoise(Bearing bearing, const NoiseLevels& noise, double range_m) {
  bearing.azimuth_variance_rad2 *= noise.bearing.value * noise.bearing.value;
  bearing.azimuth_variance_rad2 += std::pow(noise.light_size.stddev_m / range_m, 2);
  return bearing;
}

std::vector<Bearing> withNoise(std::vector<Bearing> bearings, const NoiseLevels& noise,
                               double range_m) {
  for (Bearing& bearing : bearings) bearing = withNoise(bearing, noise, range_m);
  return bearings;
}

OdometryIncrement withNoise(OdometryIncrement motion, const NoiseLevels& noise) {
  motion.covariance *= wheelFactor(noise.wheel.value, motion.has_unseen);
  return motion;
}

}  // namespace bearing_calibration::core
