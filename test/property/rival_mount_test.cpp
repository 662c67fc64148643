#include "bearing_calibration/solve/rival_mount.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/calibration/record_fit.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "support/mount_chi_square.h"
#include "support/simulated_calibration.h"
#include "tools/study/default_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using Kind = TrajectoryConfig::Kind;
using testing::mountChiSquare;

constexpr double kWrong = 25.0;  // chi-square beyond which a claim counts as wrong

ObservationRun runOf(Kind kind, std::uint64_t seed, double duration_s, double max_light_distance_m,
                     int slips = 0) {
  SimulatedCase simulated = randomCase(seed, kind, {0.7, 0.3, max_light_distance_m});
  simulated.duration_s = duration_s;
  if (slips > 0) addSlips(simulated, slips, seed);
  return simulate(simulated);
}

/// The fit of a whole record that begins at the truth.
std::optional<SlipAverage> settle(const ObservationRun& run) {
  RecordFit fit{InitializerConfig()};
  const std::size_t last = run.observations.size() - 1;
  fit.beginAt({run.truth[last], last}, run.observations);
  return fit.fit(run.observations, StateEstimate::of({run.truth[last], Matrix5::Zero()}),
                 std::nullopt);
}

Judgement judgementOn(const ObservationRun& run, const SlipAverage& settled) {
  ConvergenceJudge judge(testing::calibratorConfig().converged, ErrorPriors());
  judge.judge(MountTracker(FilterConfig(), settled.estimate, 0.0), run.observations, settled);
  return judge.last();
}

bool isOfARival(const Judgement& judgement) {
  return judgement.state == CalibrationState::kConverging &&
         judgement.advice.find("another mount") != std::string::npos;
}

TEST(RivalMount, IsAnotherOneWhereNoCovarianceExplainsIt) {
  MountEstimate mount;
  mount.covariance = Eigen::Vector3d(1e-4, 1e-4, 1e-4).asDiagonal();
  MountEstimate rival;
  for (int axis = 0; axis < 3; ++axis) {
    rival.mean = 0.0403 * Eigen::Vector3d::Unit(axis);  // 16.24 of chi-square
    EXPECT_FALSE(isAnotherMount(rival, mount));
    rival.mean *= 1.01;  // 16.57; 16.3 is what one right answer in a thousand has
    EXPECT_TRUE(isAnotherMount(rival, mount));
  }
  rival.mean.setZero();
  rival.covariance = 6.0 * mount.covariance;  // 18 on the average
  EXPECT_TRUE(isAnotherMount(rival, mount)) << "it may be anywhere";
}

TEST(RivalMount, IsOpenWithinAThousandth) {
  RivalMount rival;
  EXPECT_FALSE(rival.isOpen()) << "none came up";
  rival.offer(std::log(1100.0), Eigen::Vector3d::Ones());
  EXPECT_FALSE(rival.isOpen());
  rival.offer(std::log(900.0), Eigen::Vector3d::Zero());
  EXPECT_TRUE(rival.isOpen());
  rival.offer(std::log(1000.0), Eigen::Vector3d::Ones());
  EXPECT_EQ(rival.mount, Eigen::Vector3d::Zero()) << "the nearest one counts";
  rival.offer(-8.0, Eigen::Vector3d::Ones());
  EXPECT_TRUE(rival.isOpen()) << "a better one";
  EXPECT_EQ(rival.mount, Eigen::Vector3d::Ones());
}

// No wheel slips in it; a slip where the gain of one is the largest would give another mount.
TEST(RivalMount, ASlipThatIsNotRuledOutForbidsTheClaim) {
  const ObservationRun run = runOf(Kind::kDance, 42, 40.0, 2.0);
  std::optional<SlipAverage> settled = settle(run);
  ASSERT_TRUE(settled);
  EXPECT_TRUE(settled->rival.isOpen());
  EXPECT_GT(settled->rival.slips, 0);
  EXPECT_TRUE(isOfARival(judgementOn(run, *settled)));
  settled->rival = {};
  EXPECT_FALSE(isOfARival(judgementOn(run, *settled)));
}

// Back and forth through three slips: the fit ends in a wrong minimum. However sure of it it were,
// another one explains the record as well.
TEST(RivalMount, AnotherMinimumOfASymmetricDriveForbidsTheClaim) {
  const ObservationRun run = runOf(Kind::kBackAndForth, 7, 60.0, 3.0, 3);
  std::optional<SlipAverage> settled = settle(run);
  ASSERT_TRUE(settled);
  ASSERT_GT(mountChiSquare(settled->estimate.cartesian(), run.truth.back()), kWrong);
  EXPECT_TRUE(settled->rival.isOpen());
  settled->estimate.covariance.setIdentity();
  settled->estimate.covariance *= 1e-8;
  ASSERT_TRUE(meetsTargets(settled->estimate.mount(), testing::calibratorConfig().converged));
  EXPECT_TRUE(isOfARival(judgementOn(run, *settled)));
}

TEST(RivalMount, ADriveOfAFewSecondsHasTwoAnswers) {
  const ObservationRun run = runOf(Kind::kSinusoid, 122, 8.0, 4.0);
  const std::optional<SlipAverage> settled = settle(run);
  ASSERT_TRUE(settled);
  EXPECT_TRUE(settled->rival.isOpen());
  EXPECT_FALSE(findStart(run.observations, InitializerConfig()).ready());
  const std::optional<SlipAverage> longer = settle(runOf(Kind::kSinusoid, 122, 40.0, 4.0));
  ASSERT_TRUE(longer);
  EXPECT_FALSE(longer->rival.isOpen());
}

// At each second of drives with slips.
TEST(RivalMount, NothingIsConvergedWhileOneIsOpen) {
  constexpr double kDuration_s = 60.0;
  int open = 0;
  int converged = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SimulatedCase simulated = randomCase(seed, Kind::kTurns, {0.7, 0.3, 2.0});
    simulated.duration_s = kDuration_s;
    addSlips(simulated, 3, seed);
    const ObservationRun run = simulate(simulated);
    const EncoderConfig& encoders = simulated.robot.encoders;
    Calibrator calibrator(defaultCalibration(encoders.drive, encoders.noise));
    for (double time_s = 0.0; time_s < kDuration_s; time_s += 1.0) {
      const CalibrationResult result =
          testing::play(run.record, &calibrator, {0.0}, time_s, time_s + 1.0);
      const bool is_converged = result.state == CalibrationState::kConverged;
      converged += is_converged ? 1 : 0;
      open += result.rival.isOpen() ? 1 : 0;
      EXPECT_FALSE(is_converged && result.rival.isOpen()) << seed << ", " << time_s;
    }
  }
  EXPECT_GT(open, 0);
  EXPECT_GT(converged, 0);
}

}  // namespace
}  // namespace bearing_calibration::core
