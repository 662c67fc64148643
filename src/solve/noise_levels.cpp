#include "bearing_calibration/solve/noise_levels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {
NoiseLevels NoiseLevels::atMost() const {
  constexpr double kSigmas = 2.0;
  const auto above = [](const NoiseFactor& factor) {
    return NoiseFactor{factor.value * std::exp(kSigmas * factor.log_stddev), factor.log_stddev};
  };
  return {above(bearing), above(wheel)};
}

double NoiseLevels::mostVarianceFactor() const {
  const NoiseLevels most = atMost();
  return std::max(std::pow(most.bearing.value / bearing.value, 2), most.wheel.value / wheel.value);
}

NoiseLevels atMost(NoiseLevels levels, const NoiseLevels& limit) {
  levels.bearing.value = std::min(levels.bearing.value, limit.bearing.value);
  levels.wheel.value = std::min(levels.wheel.value, limit.wheel.value);
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

}  // namespace bearing_calibration::core
