#include "bearing_calibration/judge/convergence_judge.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/judge/driver_advice.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// The verdict on the first observations of a drive, for a filter at the truth's fit, its sensor
/// moved by so many of its standard deviations.
CalibrationState judgeFirst(std::size_t count, double sigmas, const ObservationRun& run,
                            ConvergenceJudge* judge) {
  const std::vector<Observation> record(
      run.observations.begin(), run.observations.begin() + static_cast<std::ptrdiff_t>(count));
  const BatchEstimate fit =
      BatchEstimator(BatchConfig()).estimate(record, {run.truth[count - 1], count - 1});
  SlipAverage settled{fit, fit, fit.last, {}};
  double& x = settled.estimate.mean(0);
  x += sigmas * std::sqrt(fit.last.covariance(0, 0));
  const MountTracker tracker(FilterConfig(), settled.estimate, 0.0);
  judge->judge(tracker, record, settled);
  return judge->last().state;
}

/// A mount at this x, known to a millimetre and a milliradian.
MountEstimate mountAt(double x_m) {
  MountEstimate mount;
  mount.mean << x_m, 0.1, 0.5;
  mount.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  return mount;
}

// Each mount that it leaps to must be held over its own metre and turn.
TEST(ClaimedMount, ALeapIsConfirmedByWhatComesAfterIt) {
  const auto stateOf = [](const Judgement& judgement) { return judgement.state; };
  ClaimedMount claimed;
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.1), 0.0)), CalibrationState::kConverged);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.103), 1.0)), CalibrationState::kConverged);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.2), 2.0)), CalibrationState::kConverging);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.3), 4.9)), CalibrationState::kConverging);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.3), 5.1)), CalibrationState::kConverging);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.301), 7.8)), CalibrationState::kConverging);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.301), 8.0)), CalibrationState::kConverged);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.1), 8.1)), CalibrationState::kConverging);
  EXPECT_EQ(stateOf(claimed.claim(mountAt(0.3), 8.2)), CalibrationState::kConverged);
}

/// Of an estimate that has had to take the separation for so much larger than stated.
Judgement judgedWithSeparation(double scale_error) {
  ErrorPriors priors;
  priors.setBlock(WheelSeparation::kName, 0.01);
  StateEstimate estimate = StateEstimate::zero({errorsInUse(priors), 1});
  estimate.mean.head<2>() << 0.2, 0.1;
  estimate.mean.tail<2>() << 2.0, 1.0;
  estimate.mean(kMountSize + placeOf<WheelSeparation>()) = scale_error;
  estimate.covariance.diagonal().setConstant(0.02 * 0.02);
  ConvergenceJudge judge(ConvergenceConfig{0.01, radiansFromDegrees(1.0)}, priors);
  judge.judge(MountTracker(FilterConfig(), estimate, 0.0), {}, std::nullopt);
  return judge.last();
}

// No motion makes such a mount more certain.
TEST(ConvergenceJudge, SaysWhereTheWheelsAreNotAsStated) {
  const Judgement as_stated = judgedWithSeparation(0.01);
  EXPECT_EQ(as_stated.state, CalibrationState::kConverging);
  EXPECT_NE(as_stated.advice.find("keep driving"), std::string::npos) << as_stated.advice;
  const Judgement doubtful = judgedWithSeparation(0.04);
  EXPECT_EQ(doubtful.state, CalibrationState::kConverging);
  EXPECT_NE(doubtful.advice.find("measure them again"), std::string::npos) << doubtful.advice;
  const Judgement wrong = judgedWithSeparation(0.1);
  EXPECT_EQ(wrong.state, CalibrationState::kInconsistent);
  EXPECT_EQ(wrong.cause, Fault::kSeparation);
  EXPECT_NE(wrong.advice.find("multiplied by about 1.10"), std::string::npos) << wrong.advice;
}

// With slips a fit can settle in another minimum for a moment.
TEST(ConvergenceJudge, AnAnswerThatLeapsIsConfirmedAnew) {
  constexpr double kLeap = 10.0;
  const ObservationRun run = simulate(paperCase(3));
  ConvergenceJudge judge(ConvergenceConfig{0.01, radiansFromDegrees(1.0)}, ErrorPriors());
  for (std::size_t count : {700, 850, 860}) judgeFirst(count, 0.0, run, &judge);
  ASSERT_EQ(judge.last().state, CalibrationState::kConverged);
  EXPECT_EQ(judgeFirst(865, kLeap, run, &judge), CalibrationState::kConverging);
  EXPECT_EQ(judgeFirst(870, 0.0, run, &judge), CalibrationState::kConverged) << "back again";
  EXPECT_EQ(judgeFirst(875, kLeap, run, &judge), CalibrationState::kConverging);
  EXPECT_EQ(judgeFirst(1000, kLeap, run, &judge), CalibrationState::kConverged) << "it stays so";
}

// The youngest record is the likeliest one to be misread.
TEST(ConvergenceJudge, TheFirstAnswerOfAllIsHeldAgainstTheNextOne) {
  constexpr double kLeap = 10.0;
  const ObservationRun run = simulate(paperCase(3));
  ConvergenceJudge judge(ConvergenceConfig{0.01, radiansFromDegrees(1.0)}, ErrorPriors());
  for (std::size_t count : {700, 850}) judgeFirst(count, 0.0, run, &judge);
  ASSERT_EQ(judge.last().state, CalibrationState::kConverged);
  EXPECT_EQ(judgeFirst(860, kLeap, run, &judge), CalibrationState::kConverging);
  EXPECT_EQ(judgeFirst(1000, kLeap, run, &judge), CalibrationState::kConverged) << "it stays so";
}

TEST(ConvergenceJudge, TakesBackWhatTheLatestBearingsContradict) {
  const ObservationRun run = simulate(paperCase(3));
  ConvergenceJudge judge(ConvergenceConfig{0.01, radiansFromDegrees(1.0)}, ErrorPriors());
  for (std::size_t count : {700, 850}) judgeFirst(count, 0.0, run, &judge);
  ASSERT_EQ(judge.last().state, CalibrationState::kConverged);
  RecentInnovations recent;
  EXPECT_EQ(recent.consistency().nis_mean, 0.0);
  for (int i = 0; i < RecentInnovations::kWindow; ++i) recent.noteFused(1.0);
  judge.doubt(recent.consistency());
  EXPECT_EQ(judge.last().state, CalibrationState::kConverged);
  for (int i = 0; i <= RecentInnovations::kWindow / 2; ++i) recent.noteNotFused();
  judge.doubt(recent.consistency());
  EXPECT_EQ(judge.last().state, CalibrationState::kConverging);
  EXPECT_NE(judge.last().advice.find("do not fit the motion"), std::string::npos);
  for (int i = 0; i < RecentInnovations::kWindow; ++i) recent.noteFused(1.0);
  judge.doubt(recent.consistency());
  EXPECT_EQ(judge.last().state, CalibrationState::kConverging) << "until the next fit";
  EXPECT_EQ(judgeFirst(860, 0.0, run, &judge), CalibrationState::kConverged);
}

TEST(DriverAdvice, NamesWhatIsKnownLeast) {
  StartAttempt attempt;
  attempt.obstacle = StartObstacle::kWeakDirection;
  attempt.weakest.direction << 0.7, 0.0, -0.7, 0.1, 0.1;
  attempt.weakest.stddev_m = 0.12;
  const std::string advice = adviceFor(attempt);
  EXPECT_NE(advice.find("known least: +0.7 light x -0.7 sensor x, to 0.120 m"), std::string::npos)
      << advice;
}

StartAttempt afterMoving(double path_m, double turn_rad, StartObstacle obstacle) {
  StartAttempt attempt;
  attempt.obstacle = obstacle;
  attempt.motion.path_m = path_m;
  attempt.motion.turn_rad = turn_rad;
  return attempt;
}

// A mount is told by a way and by turns: either alone leaves one that fits to be found yet.
TEST(DriverAdvice, NothingFitsOnlyAfterBothAWayAndTurns) {
  constexpr double kLongWay_m = 20.0;
  constexpr double kManyTurns_rad = 20.0 * kPi;
  for (const StartObstacle obstacle : {StartObstacle::kNoSolution, StartObstacle::kPoorFit}) {
    EXPECT_FALSE(doesNotFit(afterMoving(kLongWay_m, 0.0, obstacle)));
    EXPECT_FALSE(doesNotFit(afterMoving(0.0, kManyTurns_rad, obstacle)));
    EXPECT_TRUE(doesNotFit(afterMoving(kLongWay_m, kManyTurns_rad, obstacle)));
  }
  EXPECT_FALSE(doesNotFit(afterMoving(kLongWay_m, kManyTurns_rad, StartObstacle::kNone)));
}

/// A drive whose second half has its bearings from a mount that is turned by 6 deg.
ObservationRun turnedHalfway() {
  ObservationRun run = simulate(paperCase(3));
  for (std::size_t i = run.observations.size() / 2; i < run.observations.size(); ++i)
    run.observations[i].azimuth_rad += radiansFromDegrees(6.0);
  return run;
}

BatchEstimate fitOf(const ObservationRun& run) {
  const std::size_t last = run.observations.size() - 1;
  return BatchEstimator(BatchConfig()).estimate(run.observations, {run.truth[last], last});
}

TEST(ConvergenceJudge, OneMountIsToldByPartsThatGiveTheSame) {
  const ObservationRun steady = simulate(paperCase(3));
  const ObservationRun turned = turnedHalfway();
  const auto isOneMount = [](const ObservationRun& run) {
    const BatchEstimate fit = fitOf(run);
    EXPECT_TRUE(fit.converged);
    return tellsOneMount(MountTracker(FilterConfig(), fit.last, 0.0), run.observations, fit);
  };
  EXPECT_TRUE(isOneMount(steady));
  EXPECT_FALSE(isOneMount(turned));
}

// A fault where the noise is known.
TEST(ConvergenceJudge, PartsThatMoreNoiseExplainsAreNoFault) {
  const ObservationRun run = turnedHalfway();
  const BatchEstimate fit = fitOf(run);
  ASSERT_TRUE(fit.converged);
  const SlipAverage settled{fit, fit, fit.last, {}};
  const MountTracker tracker(FilterConfig(), fit.last, 0.0);
  const auto judgementWith = [&](const NoiseMargin& margin) {
    ConvergenceJudge judge(ConvergenceConfig{0.01, radiansFromDegrees(1.0)}, ErrorPriors());
    judge.judge(tracker, run.observations, settled, margin);
    return judge.last();
  };
  EXPECT_EQ(judgementWith({}).cause, Fault::kPartsDisagree);
  const Judgement doubtful = judgementWith({1.0, 50.0});
  EXPECT_EQ(doubtful.state, CalibrationState::kConverging);
  EXPECT_NE(doubtful.advice.find("noise"), std::string::npos) << doubtful.advice;
}

}  // namespace
}  // namespace bearing_calibration::core
