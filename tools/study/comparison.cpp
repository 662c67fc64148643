#include "tools/study/comparison.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "tools/common/parallel.h"

namespace bearing_calibration::core {
namespace {

constexpr double kShort_s = 35.0;

SimulatedCase asStated(SimulatedCase simulated) {
  simulated.stated_noise = NoiseLevels();
  return simulated;
}

/// Half of the bearings' standard deviation, a quarter of the wheels' variance.
SimulatedCase statedTooSmall(SimulatedCase simulated) {
  simulated.stated_noise = NoiseLevels();
  simulated.stated_noise.bearing.value = 0.5;
  simulated.stated_noise.wheel.value = 0.25;
  return simulated;
}

SimulatedCase shortDrive(std::uint64_t seed) {
  SimulatedCase simulated = shortCase(seed);
  simulated.duration_s = kShort_s;
  return simulated;
}

SimulatedCase lateAndUnequal(std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  ImperfectRobot robot;
  robot.time_offset_s = 0.05;
  robot.ratio = 0.01;
  makeImperfect(simulated, robot, seed);
  return simulated;
}

/// Of values that are not negative.
struct Spread {
  double median = 0.0;
  double rms = 0.0;
};

Spread spreadOf(const std::vector<double>& values) {
  if (values.empty()) return {};
  double squares = 0.0;
  for (double value : values) squares += value * value;
  return {medianOf(values), std::sqrt(squares / static_cast<double>(values.size()))};
}

/// Two digits after the point, of large numbers none.
std::string shown(double value) {
  constexpr double kLarge = 10.0;
  return value < kLarge ? formatted("%.2f", value) : formatted("%.0f", value);
}

double totalMilliseconds(const std::vector<Snapshot>& snapshots) {
  double sum = 0.0;
  for (const Snapshot& snapshot : snapshots) sum += snapshot.milliseconds;
  return sum;
}

std::string rowOf(const std::string& name, const std::vector<Snapshot>& snapshots,
                  double plain_milliseconds) {
  constexpr double kMountDegrees = 3.0;
  std::vector<double> off_mm, yaw_deg;
  double chi_square = 0.0;
  int sure = 0;
  int wrong = 0;
  for (const Snapshot& snapshot : snapshots) {
    if (!snapshot.has_estimate) continue;
    off_mm.push_back(kMillimetresPerMetre *
                     snapshot.error.segment<2>(CartesianIndex::kSensorX).norm());
    yaw_deg.push_back(degreesFromRadians(std::abs(snapshot.error(CartesianIndex::kSensorYaw))));
    chi_square += snapshot.mountChiSquare();
    sure += snapshot.claims ? 1 : 0;
    wrong += snapshot.claims && snapshot.failed() ? 1 : 0;
  }
  const double answers = static_cast<double>(off_mm.size());
  const Spread off = spreadOf(off_mm);
  const Spread yaw = spreadOf(yaw_deg);
  const double nees = chi_square / (kMountDegrees * std::max(1.0, answers));
  return formatted("| %s | %zu of %zu | %.1f, %.1f | %.2f, %.2f | %s | %d | %d | %s |\n",
                   name.c_str(), off_mm.size(), snapshots.size(), off.median, off.rms, yaw.median,
                   yaw.rms, shown(nees).c_str(), sure, wrong,
                   shown(totalMilliseconds(snapshots) / plain_milliseconds).c_str());
}

}  // namespace

const std::vector<ComparisonSetting>& comparisonSettings() {
  static const std::vector<ComparisonSetting> kSettings = {
      {"The paper's world, 100 s, noise as stated",
       [](std::uint64_t seed) { return asStated(paperCase(seed)); }},
      {"The paper's world, 100 s, noise twice what is stated",
       [](std::uint64_t seed) { return statedTooSmall(paperCase(seed)); }},
      {"The paper's world, 100 s, noise as stated, camera 50 ms late, wheels 1 % unequal",
       lateAndUnequal},
      {"The short drive, 35 s, noise as stated",
       [](std::uint64_t seed) { return asStated(shortDrive(seed)); }},
      {"The short drive, 35 s, noise twice what is stated",
       [](std::uint64_t seed) { return statedTooSmall(shortDrive(seed)); }},
  };
  return kSettings;
}

std::vector<std::vector<Snapshot>> compare(const ComparisonSetting& setting, int runs,
                                           int threads) {
  const std::vector<ComparedEstimator>& estimators = comparedEstimators();
  const auto count = static_cast<std::size_t>(runs);
  std::vector<std::vector<Snapshot>> snapshots(estimators.size(), std::vector<Snapshot>(count));
  forEachInParallel(count, threads, [&](std::size_t i) {
    const std::uint64_t seed = i + 1;
    const ComparedRun run = comparedRun(setting.make(seed), seed);
    for (std::size_t j = 0; j < estimators.size(); ++j) snapshots[j][i] = estimators[j].run(run);
  });
  return snapshots;
}

std::string formatGiven() {
  std::string text = "| estimator | given beside bearings and wheels |\n|---|---|\n";
  for (const ComparedEstimator& estimator : comparedEstimators()) {
    text += formatted("| %s | %s |\n", estimator.name.c_str(), estimator.given.c_str());
  }
  return text;
}

std::string formatComparison(const ComparisonSetting& setting,
                             const std::vector<std::vector<Snapshot>>& snapshots) {
  std::string text =
      "**" + setting.name +
      "**\n\n| estimator | answers | position off, median, RMS [mm] | yaw off, median, RMS [deg] | "
      "NEES/3 | sure | wrong of these | CPU time / plain EKF "
      "|\n|---|---|---|---|---|---|---|---|\n";
  const double plain_milliseconds = totalMilliseconds(snapshots[kPlainFilter]);
  for (std::size_t i = 0; i < snapshots.size(); ++i) {
    text += rowOf(comparedEstimators()[i].name, snapshots[i], plain_milliseconds);
  }
  return text;
}

}  // namespace bearing_calibration::core
