#include "bearing_calibration/output/sensor_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {
namespace {

/// Sums over the deviations of some stops' bearings from each stop's mean.
struct Deviations {
  double squares = 0.0;
  double products = 0.0;  ///< of neighbours
  std::size_t count = 0;
  std::size_t stops = 0;

  void add(const std::vector<double>& azimuths_rad) {
    if (azimuths_rad.empty()) return;
    const double sum = std::accumulate(azimuths_rad.begin(), azimuths_rad.end(), 0.0);
    const double mean = sum / static_cast<double>(azimuths_rad.size());
    double last = 0.0;
    for (double azimuth_rad : azimuths_rad) {
      const double off = azimuth_rad - mean;
      squares += off * off;
      products += off * last;
      last = off;
    }
    count += azimuths_rad.size();
    ++stops;
  }

  /// Of neighbours. From n bearings about their own mean it comes out too small by (1 + 3 rho) / n
  /// (Marriott and Pope, 1954).
  double correlation() const {
    constexpr double kMost = 0.99;
    constexpr double kFewest = 5.0;
    const double n = std::max(static_cast<double>(count) / static_cast<double>(stops), kFewest);
    return std::clamp((products / squares + 1.0 / n) / (1.0 - 3.0 / n), 0.0, kMost);
  }
  /// Of one bearing: the means have taken some of it with them.
  double variance() const {
    const double all = static_cast<double>(count);
    const double lost = static_cast<double>(stops) * wideningFor(correlation());
    return squares / std::max(all - lost, 0.5 * all);
  }
};

/// A stop's azimuths, each less their median.
std::vector<double> aboutMedian(const std::vector<Observation>& observations, const Stretch& stop) {
  std::vector<double> azimuths_rad;
  const double first_rad = observations[stop.begin].azimuth_rad;
  for (std::size_t i = stop.begin; i < stop.end; ++i)
    azimuths_rad.push_back(wrapAngle(observations[i].azimuth_rad - first_rad));
  const double median_rad = medianOf(azimuths_rad);
  for (double& azimuth_rad : azimuths_rad) azimuth_rad = wrapAngle(azimuth_rad - median_rad);
  return azimuths_rad;
}

/// Standard deviation of what is normal but for a few; more than half may be the same number, as a
/// coarse sensor measures it.
double stddevOfMost(std::vector<double> deviations) {
  constexpr double kShare = 0.8;
  constexpr double kQuantileOfNormal = 1.28155;  // of its absolute value
  for (double& deviation : deviations) deviation = std::abs(deviation);
  const double found = quantileOf(std::move(deviations), kShare) / kQuantileOfNormal;
  return found > 0.0 ? found : std::numeric_limits<double>::infinity();
}

StandingBearings standingIn(const std::vector<Observation>& observations,
                            const std::vector<Stretch>& stops) {
  constexpr double kOutlierSigmas = 5.0;
  StandingBearings standing;
  std::vector<double> all;
  double stated_rad2 = 0.0;
  for (const Stretch& stop : stops) {
    const std::vector<double> azimuths_rad = aboutMedian(observations, stop);
    all.insert(all.end(), azimuths_rad.begin(), azimuths_rad.end());
    for (std::size_t i = stop.begin; i < stop.end; ++i)
      stated_rad2 += observations[i].azimuth_variance_rad2;
    standing.duration_s += secondsBetween(observations[stop.begin], observations[stop.end - 1]);
  }
  const double limit_rad = kOutlierSigmas * stddevOfMost(all);
  Deviations deviations;
  for (const Stretch& stop : stops) {
    std::vector<double> azimuths_rad = aboutMedian(observations, stop);
    azimuths_rad.erase(std::remove_if(azimuths_rad.begin(), azimuths_rad.end(),
                                      [&](double off) { return std::abs(off) > limit_rad; }),
                       azimuths_rad.end());
    deviations.add(azimuths_rad);
  }
  const double count = static_cast<double>(all.size());
  standing.stops = static_cast<int>(stops.size());
  standing.bearings = static_cast<int>(all.size());
  standing.stated_stddev_rad = std::sqrt(stated_rad2 / count);
  standing.outlier_share = 1.0 - static_cast<double>(deviations.count) / count;
  if (!(deviations.squares > 0.0)) return standing;
  standing.stddev_rad = std::sqrt(deviations.variance());
  const double correlation = deviations.correlation();
  if (correlation > 2.0 / std::sqrt(count))  // white noise shows less
    standing.correlation_time_s = -usualInterval(observations) / std::log(correlation);
  return standing;
}

std::optional<StandingBearings> checkStanding(const std::vector<Observation>& observations) {
  constexpr double kSpeed_mps = 2e-3;
  constexpr double kTurn_radps = 5e-3;
  constexpr double kShortest_s = 1.0;
  constexpr std::size_t kFewestInStop = 5;
  constexpr std::size_t kFewestBearings = 30;
  std::vector<Stretch> stops = stretchesOf(observations, [&](std::size_t i) {
    const OdometryIncrement& motion = observations[i].motion;
    const double interval_s = secondsBetween(observations[i - 1], observations[i]);
    return motion.distance_m <= kSpeed_mps * interval_s &&
           motion.rotation_rad <= kTurn_radps * interval_s;
  });
  stops.erase(std::remove_if(stops.begin(), stops.end(),
                             [&](const Stretch& stop) {
                               return stop.size() < kFewestInStop ||
                                      secondsBetween(observations[stop.begin],
                                                     observations[stop.end - 1]) < kShortest_s;
                             }),
              stops.end());
  std::size_t bearings = 0;
  for (const Stretch& stop : stops) bearings += stop.size();
  if (bearings < kFewestBearings) return std::nullopt;
  return standingIn(observations, stops);
}

std::string inWords(const StandingBearings& standing) {
  const std::string correlated =
      standing.correlation_time_s > 0.0
          ? formatted("correlated over %.2f s", standing.correlation_time_s)
          : std::string("without a correlation in time");
  const std::string outliers =
      standing.outlier_share > 0.0
          ? formatted("; %.1f %% lie farther off", 100.0 * standing.outlier_share)
          : std::string();
  return formatted(
      "standing, %d bearings in %d stops of %.0f s together scatter by %.3f deg where %.3f deg are "
      "stated, %s%s",
      standing.bearings, standing.stops, standing.duration_s,
      degreesFromRadians(standing.stddev_rad), degreesFromRadians(standing.stated_stddev_rad),
      correlated.c_str(), outliers.c_str());
}

std::vector<std::string> inWords(const TurningBearings& turning) {
  std::vector<std::string> sentences = {formatted(
      "turning on the spot, %d bearings in %.1f turns scatter by %.3f deg, and the robot turns by "
      "%.2f +- %.2f %% more than its wheels say",
      turning.bearings, turning.turn_rad / (2.0 * kPi), degreesFromRadians(turning.stddev_rad),
      100.0 * turning.more_turn.value, 100.0 * turning.more_turn.stddev)};
  sentences.push_back(
      turning.tells_latency
          ? formatted("the bearings' stamps are late by %.3f +- %.3f s beyond bearings/latency",
                      turning.late_s.value, turning.late_s.stddev)
          : std::string("the bearings' latency does not show at a constant rate of turn: start and "
                        "stop, and turn both ways"));
  return sentences;
}

}  // namespace

SensorCheck checkSensor(const std::vector<Observation>& observations) {
  return {checkStanding(observations), checkTurning(observations)};
}

std::vector<std::string> inWords(const SensorCheck& check) {
  std::vector<std::string> sentences;
  sentences.push_back(check.standing
                          ? inWords(*check.standing)
                          : "the robot does not stand long enough to determine the bearings' "
                            "noise: let it stand for ten seconds in view of the light");
  if (!check.turning) {
    sentences.emplace_back(
        "the robot does not turn on the spot far enough to determine the bearings' latency: let it "
        "turn once each way, with stops");
    return sentences;
  }
  for (const std::string& sentence : inWords(*check.turning)) sentences.push_back(sentence);
  return sentences;
}

}  // namespace bearing_calibration::core
