// The levels of the noise: found against the truth over many runs, and held where a record is
// short.
#include "bearing_calibration/solve/noise_review.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/output/error_report.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

constexpr NoisePriors kPriors{1.0, 1.5};

struct Record {
  std::vector<Observation> observations;
  BatchEstimate fit;
};

/// A run of the paper, its noise stated so many times as large as it is, with the batch begun at
/// the truth.
Record recordOf(std::uint64_t seed, double duration_s, const NoiseLevels& stated) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = duration_s;
  const ObservationRun run = simulate(simulated);
  Record record;
  record.observations = withNoise(run.observations, stated);
  BatchConfig config;
  config.reject_sigmas = 0.0;  // there is nothing to reject, and no tail to be cut
  config.slip_gain = 0.0;
  record.fit = BatchEstimator(config).estimate(record.observations,
                                               {run.truth.back(), record.observations.size() - 1});
  return record;
}

TEST(NoiseLevels, AreFoundAsWellAsTheySay) {
  constexpr int kRuns = 20;
  constexpr double kFalseAlarm = 1e-3;
  const NoiseLevels stated{{0.5, 0.0}, {0.25, 0.0}};
  double bearing_nees = 0.0;
  double wheel_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Record record = recordOf(seed, 100.0, stated);
    const NoiseLevels found = reviewNoise(record.observations, record.fit, {}, kPriors, {}).levels;
    bearing_nees += std::pow(std::log(2.0 / found.bearing.value) / found.bearing.log_stddev, 2);
    wheel_nees += std::pow(std::log(4.0 / found.wheel.value) / found.wheel.log_stddev, 2);
    EXPECT_LT(found.bearing.log_stddev, 0.05) << seed;
  }
  for (double nees : {bearing_nees, wheel_nees}) {
    EXPECT_LT(nees, chiSquareQuantile(1.0 - kFalseAlarm, kRuns));
    EXPECT_GT(nees, chiSquareQuantile(kFalseAlarm, kRuns));
  }
}

TEST(NoiseLevels, AFactorThatIsNotLookedForStaysAsStated) {
  const Record record = recordOf(1, 50.0, {});
  const NoiseLevels found = reviewNoise(record.observations, record.fit, {}, {1.0, 0.0}, {}).levels;
  EXPECT_EQ(found.wheel.value, 1.0);
  EXPECT_EQ(found.wheel.log_stddev, 0.0);
  EXPECT_LT(std::abs(std::log(found.bearing.value)), 3.0 * found.bearing.log_stddev);
}

TEST(NoiseLevels, TheWheelsOfAShortWayAreHeldAtTheirPrior) {
  const Record record = recordOf(2, 5.0, {});
  const NoiseLevels found = reviewNoise(record.observations, record.fit, {}, {0.7, 0.7}, {}).levels;
  const std::vector<BlockReport> reports = reportNoise({0.7, 0.7}, found, {});
  EXPECT_EQ(reports[0].status, BlockStatus::kEstimated);
  EXPECT_EQ(reports[1].status, BlockStatus::kHeldAtPrior);
  EXPECT_FALSE(reports[1].note.empty());
  EXPECT_EQ(reports[2].status, BlockStatus::kOff);
}

TEST(NoiseLevels, CorrelationForgetsItselfInItsTime) {
  std::vector<Observation> observations(400);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    observations[i].stamp = Stamp(std::chrono::milliseconds(100 * i));
  }
  const CorrelationTime time = correlationTime(observations, std::exp(-0.5));
  EXPECT_NEAR(time.value_s, 0.2, 1e-9);  // two intervals
  EXPECT_NEAR(time.stddev_s, 0.1 / (std::exp(-0.5) * 0.25) / 20.0, 1e-9);
  EXPECT_EQ(correlationTime(observations, 0.0).value_s, 0.0);
}

TEST(NoiseLevels, PriorsAreChecked) {
  EXPECT_TRUE(kPriors.validate().empty());
  EXPECT_EQ((NoisePriors{-1.0, NAN}.validate().size()), 2U);
}

}  // namespace
}  // namespace bearing_calibration::core
