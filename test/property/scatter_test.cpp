#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/solve/batch_estimator.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// Of the mean gain of a sound robot: sqrt(3 * 0.58), that of one dimension known in closed form.
constexpr double kStddev = 1.32;

SimulatedCase danceCase(std::uint64_t seed, double correlation) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = 40.0;
  simulated.robot.sensor.correlation = correlation;
  return simulated;
}

ObservationRun dance(std::uint64_t seed, double correlation) {
  return simulate(danceCase(seed, correlation));
}

BatchEstimate fit(const ObservationRun& run, const BatchConfig& config) {
  const std::size_t last = run.observations.size() - 1;
  return BatchEstimator(config).estimate(run.observations, {run.truth[last], last});
}

// Mean and 99 % quantile of an Anderson-Darling statistic, summed over three dimensions.
TEST(Scatter, OfASoundRobotIsWhatChanceGives) {
  constexpr int kRuns = 40;
  constexpr int kMostWidened =
      4;  // of 40 with a probability of 2 % each, 1 % by either rule: 99.9 %
  double sum = 0.0;
  int runs_widened = 0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    const Scatter scatter =
        fit(dance(static_cast<std::uint64_t>(seed), 0.0), BatchConfig()).scatter();
    ASSERT_GT(scatter.observations, 100U) << "seed " << seed;
    sum += scatter.meanGain();
    runs_widened += scatter.widening() > 1.0 ? 1 : 0;
  }
  EXPECT_NEAR(sum / kRuns, 3.0, 4.0 * kStddev / std::sqrt(kRuns));
  EXPECT_LE(runs_widened, kMostWidened);
}

// Bearings correlated by r are worth (1 + r) / (1 - r) times fewer, and with wheels that hardly
// err, they alone make the mount's variance: the mean is so many times that of a sound robot.
TEST(Scatter, ShowsACorrelationThatTheFitDoesNotKnow) {
  constexpr double kCorrelation = 0.8;
  constexpr double kInflation = (1.0 + kCorrelation) / (1.0 - kCorrelation);
  constexpr int kRuns = 40;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = danceCase(seed, kCorrelation);
    simulated.robot.encoders.noise.independent_k_m = 1e-9;
    const Scatter scatter = fit(simulate(simulated), BatchConfig::leastSquares()).scatter();
    sum += scatter.meanGain();
    EXPECT_GE(scatter.widening(), scatter.largest_gain / 21.0) << "seed " << seed;
  }
  EXPECT_NEAR(sum / kRuns, 3.0 * kInflation, 4.0 * kStddev * kInflation / std::sqrt(kRuns));
}

// A mount that jumps at one moment, by so much that a test of that moment has a gain of 60.
TEST(Scatter, ShowsAJumpThatHardlyMovesTheMean) {
  BatchEstimate one_jump;
  one_jump.mount_displacements.resize(1000);
  for (MountDisplacement& jump : one_jump.mount_displacements) {
    jump.information = 1e6 * Eigen::Matrix3d::Identity();
    jump.pull = Eigen::Vector3d::Constant(std::sqrt(1e6));  // a gain of 3
  }
  const Scatter without = one_jump.scatter();
  EXPECT_NEAR(without.meanGain(), 3.0, 1e-9);
  EXPECT_EQ(without.widening(), 1.0);
  one_jump.mount_displacements[500].pull = Eigen::Vector3d::Constant(std::sqrt(20e6));
  EXPECT_NEAR(one_jump.scatter().widening(), 60.0 / 21.0, 1e-9);
}

// What a record gives away takes its scatter with it: nothing of it is lost or counted twice.
TEST(Scatter, IsTheSameOfARecordThatWasCut) {
  const ObservationRun run = dance(3, 0.5);
  const BatchConfig plain = BatchConfig::leastSquares();
  const BatchEstimator estimator(plain);
  const BatchEstimate whole = fit(run, plain);
  const std::size_t count = run.observations.size() / 2;
  RecordBeginning beginning;
  beginning.known = estimator.knownAt(count - 1, run.observations, whole);
  beginning.scatter.giveAway(scatterOf(whole.mount_displacements, 0, count));
  const std::vector<Observation> later(
      run.observations.begin() + static_cast<std::ptrdiff_t>(count), run.observations.end());
  const BatchEstimate rest =
      estimator.estimate(later, {run.truth.back(), later.size() - 1}, {}, beginning);
  ASSERT_TRUE(rest.converged);
  const Scatter sum = rest.scatter();
  EXPECT_EQ(sum.observations, whole.scatter().observations);
  EXPECT_NEAR(sum.meanGain(), whole.scatter().meanGain(), 0.02 * sum.meanGain());
}

TEST(Scatter, WidensMountAndLightAndLeavesTheRobotsErrors) {
  const ErrorEstimate errors{ErrorVector::Zero(), 1e-4 * ErrorMatrix::Identity()};
  StateEstimate linked =
      StateEstimate::of(fit(dance(1, 0.0), BatchConfig()).last.cartesian(), kErrorCount, errors);
  constexpr int kOffset = kMountSize + placeOf<TimeOffset>();
  const auto correlation = [](const StateMatrix& P) {
    return P(0, kOffset) / std::sqrt(P(0, 0) * P(kOffset, kOffset));
  };
  linked.covariance(0, kOffset) =
      0.99 * std::sqrt(linked.covariance(0, 0) * linked.covariance(kOffset, kOffset));
  linked.covariance(kOffset, 0) = linked.covariance(0, kOffset);
  const StateEstimate wide = widened(linked, 4.0);
  EXPECT_TRUE(wide.cartesian().covariance.isApprox(4.0 * linked.cartesian().covariance));
  EXPECT_EQ(wide.errors().covariance, linked.errors().covariance);
  EXPECT_EQ(wide.mean, linked.mean);
  EXPECT_NEAR(correlation(wide.covariance), 0.99, 1e-9);
}

}  // namespace
}  // namespace bearing_calibration::core
