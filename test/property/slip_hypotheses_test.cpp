#include "bearing_calibration/solve/slip_hypotheses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "support/mount_chi_square.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using testing::mountChiSquare;

/// Three slips in 100 s, of which the record sees those of its first seconds.
ObservationRun slippingRun(std::uint64_t seed, TrajectoryConfig::Kind kind, double seen_s) {
  SimulatedCase simulated = randomCase(seed, kind, RandomCaseRange());
  addSlips(simulated, 3, seed);
  simulated.duration_s = seen_s;
  return simulate(simulated);
}

BatchEstimate fit(const ObservationRun& run, const SlipHypothesis& slips = {}) {
  const std::size_t last = run.observations.size() - 1;
  return BatchEstimator(BatchConfig()).estimate(run.observations, {run.truth[last], last}, slips);
}

// The record of seed 5 puts a slip in the wrong place, where it costs as little.
TEST(SlipHypotheses, ASlipAtTheWrongPlaceIsNotBelieved) {
  constexpr double kWrong = 25.0;  // chi-square beyond which a claim counts as wrong
  const ObservationRun run = slippingRun(5, TrajectoryConfig::Kind::kTurns, 20.0);
  const BatchEstimate batch = fit(run);
  ASSERT_TRUE(batch.converged);
  ASSERT_GT(mountChiSquare(batch.last.cartesian(), run.truth.back()), kWrong);
  const SlipAverage average = averageOverSlips(run.observations, batch, BatchConfig());
  EXPECT_LT(mountChiSquare(average.estimate.cartesian(), run.truth.back()), kWrong);
  EXPECT_LE(average.best.cost, batch.cost);
}

TEST(SlipHypotheses, ARecordWithoutSuspicionIsLeftAsItIs) {
  SimulatedCase simulated = paperCase(3);
  simulated.duration_s = 20.0;
  const ObservationRun run = simulate(simulated);
  const BatchEstimate batch = fit(run);
  ASSERT_TRUE(batch.slips.empty());
  ASSERT_LT(batch.suspicion, 9.0);
  const SlipAverage average = averageOverSlips(run.observations, batch, BatchConfig());
  EXPECT_TRUE(average.estimate.cartesian().mean.isApprox(batch.last.cartesian().mean));
  EXPECT_TRUE(average.estimate.cartesian().covariance.isApprox(batch.last.cartesian().covariance));
  EXPECT_FALSE(average.rival.isOpen());
}

// Where a slip is not given up, innovations hang together, and more so in noise that does, too: by
// its own correlation such a fit counts each bearing for so much less that it may be the cheaper
// one.
TEST(SlipHypotheses, AFitIsNotMadeCheapByItsOwnMisfit) {
  int cheaper_by_own = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimulatedCase simulated = paperCase(seed);
    simulated.robot.sensor.correlation = 0.4;
    simulated.duration_s = 20.0;
    simulated.robot.faults.slips.push_back({{10.0, 0.3}, WheelSlip::Wheel::kLeft, 0.4});
    const ObservationRun run = simulate(simulated);
    const BatchEstimate found = fit(run);
    ASSERT_TRUE(found.converged && !found.slips.empty()) << seed;
    SlipHypothesis none;
    none.trusted = found.slips;
    none.most_further = 0;
    const std::size_t last = run.observations.size() - 1;
    const BatchEstimate alike = BatchEstimator(BatchConfig().weighedAs(found))
                                    .estimate(run.observations, {run.truth[last], last}, none);
    EXPECT_EQ(alike.correlation, found.correlation) << seed;
    EXPECT_GT(alike.cost, found.cost) << seed;
    if (fit(run, none).cost < found.cost) ++cheaper_by_own;
  }
  EXPECT_GT(cheaper_by_own, 0);
}

// The prior of a slip is proportional to the time in which it may have happened.
TEST(SlipHypotheses, ASlipInALongerMotionCostsLess) {
  constexpr std::size_t kSlip = 40;
  constexpr double kInterval_s = 0.5;  // no other motion is given up with this one
  constexpr double kHidden_s = 4.0;
  SimulatedCase simulated = paperCase(3);
  simulated.robot.steps_per_bearing =
      static_cast<int>(std::lround(kInterval_s / simulated.robot.step_s));
  ObservationRun run = simulate(simulated);
  SlipHypothesis slip;
  slip.given_up = {kSlip};
  slip.most_further = 0;
  const BatchEstimate seen = fit(run, slip);
  for (std::size_t i = kSlip; i < run.observations.size(); ++i) {
    run.observations[i].stamp += durationFromSeconds(kHidden_s);
  }
  const BatchEstimate hidden = fit(run, slip);
  EXPECT_NEAR(seen.cost - hidden.cost, 2.0 * std::log((kInterval_s + kHidden_s) / kInterval_s),
              1e-9);
}

TEST(SlipHypotheses, AnotherLightForAWhileIsNoSlip) {
  const Eigen::Vector2d another_m(-1.5, 2.0);
  const SimulatedCase simulated = paperCase(4);
  ObservationRun run = simulate(simulated);
  const auto isReplaced = [](std::size_t i) { return i >= 600 && i < 640; };
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    if (!isReplaced(i)) continue;
    const Pose2 world_from_sensor = run.world_from_base[i] * simulated.robot.base_from_sensor;
    const Eigen::Vector2d light = world_from_sensor.inverse() * another_m;
    run.observations[i].azimuth_rad = std::atan2(light.y(), light.x());
  }
  const BatchEstimate batch = fit(run);
  ASSERT_TRUE(batch.converged);
  EXPECT_TRUE(batch.slips.empty());
  for (std::size_t rejected : batch.rejected) EXPECT_TRUE(isReplaced(rejected)) << rejected;
  EXPECT_GT(batch.rejected.size(), 35U) << "but for those where the two lights are in line";
}

// Outliers may lie in a cluster, where a slip would hide them: that is no reason to believe in one.
TEST(SlipHypotheses, ASlipDoesNotPayForTheOutliersThatItHides) {
  int slips = 0;
  constexpr int kRecords = 40;
  for (std::uint64_t seed = 1; seed <= kRecords; ++seed) {
    SimulatedCase simulated = paperCase(seed);
    simulated.robot.sensor.outlier_probability = 0.2;
    const ObservationRun run = simulate(simulated);
    slips += static_cast<int>(
        averageOverSlips(run.observations, fit(run), BatchConfig()).best.slips.size());
  }
  EXPECT_LE(slips, 6) << "of " << kRecords << " records without one";
}

TEST(SlipHypotheses, SuppositionsAreFollowed) {
  const ObservationRun run = slippingRun(157, TrajectoryConfig::Kind::kDance, 40.0);
  const std::size_t slip = fit(run).slips.at(0);
  SlipHypothesis elsewhere;
  elsewhere.trusted = {slip};
  for (std::size_t other : fit(run, elsewhere).slips) EXPECT_NE(other, slip);
  SlipHypothesis given;
  given.given_up = {slip + 100};
  given.most_further = 0;
  EXPECT_EQ(fit(run, given).slips, given.given_up);
  given.given_up = {run.observations.size()};
  EXPECT_THROW(fit(run, given), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
