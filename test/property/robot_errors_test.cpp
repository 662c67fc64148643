// The robot's errors: Jacobians against numerical differentiation, what they do against a simulator
// that knows nothing of the blocks, and the estimators that find them.
#include "bearing_calibration/filter/robot_errors.h"

#include <gtest/gtest.h>

#include <random>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "support/mount_chi_square.h"
#include "support/numerical_jacobian.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using testing::largestDifference;
using testing::mountChiSquare;
using testing::numericalJacobian;

constexpr double kJacobianTolerance = 1e-6;
constexpr int kLights = 2;
constexpr int kWholeErrors = heightAt(kLights);
constexpr int kWholeSize = kMountSize + kWholeErrors + 2 * kLights;
using WholeState = Eigen::Matrix<double, kWholeSize, 1>;
constexpr StateLayout kWhole{kWholeErrors, kLights};

/// Errors as large as their priors allow, the same at every run.
class Draws {
 public:
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  ErrorVector errors() {
    ErrorVector errors;
    for (double& error : errors) error = between(-0.05, 0.05);
    return errors;
  }

 private:
  std::mt19937_64 engine_{20060515};
};

/// A motion of many arcs, as the encoders of a robot with other wheels would report it.
OdometryIncrement motionOf(const ErrorVector& errors, double nominal_separation_m) {
  const WheelFactors wheels{1.0 + errors(1), 1.0 + errors(2), 1.0 + errors(3)};
  OdometryIncrement motion;
  for (int i = 0; i < 20; ++i) {
    const WheelDisplacement step{0.004 - 0.0003 * i, 0.003 + 0.0001 * i};
    motion = append(motion, {wheels.left * step.left_m, wheels.right * step.right_m},
                    nominal_separation_m * wheels.separation, WheelNoise{});
  }
  return motion;
}

TEST(RobotErrors, MotionFollowsTheWheelsAndItsJacobianIsRight) {
  constexpr double kSeparation_m = 0.25;
  Draws draws;
  const OdometryIncrement believed = motionOf(ErrorVector::Zero(), kSeparation_m);
  for (int i = 0; i < 50; ++i) {
    const ErrorVector errors = draws.errors();
    const Pose2 expected = motionOf(errors, kSeparation_m).start_from_end;
    const auto corrected = correctMotion(believed, errors);
    // The turn is exact. The chord's error is of second order: turn error times way, squared.
    EXPECT_NEAR(corrected.start_from_end.yaw_rad, expected.yaw_rad, 1e-12);
    EXPECT_LT((corrected.start_from_end.position_m - expected.position_m).norm(), 3e-4);
    const auto numerical = numericalJacobian<3, kErrorCount>(
        [&](const ErrorVector& at) -> Eigen::Vector3d {
          const Pose2 pose = correctMotion(believed, at).start_from_end;
          return {pose.position_m.x(), pose.position_m.y(), pose.yaw_rad};
        },
        errors, {2});
    EXPECT_LT(largestDifference(corrected.J_pose_errors, numerical), kJacobianTolerance);
  }
}

/// A robot that drives an arc at a constant speed.
OdometryWindow steadyTravel(double left_mps, double right_mps) {
  std::array<WheelDisplacement, OdometryWindow::kSamples> samples;
  for (int i = 0; i < OdometryWindow::kSamples; ++i) {
    const double time_s = (i - OdometryWindow::kBefore) * OdometryWindow::kStep_s;
    samples[static_cast<std::size_t>(i)] = {left_mps * time_s, right_mps * time_s};
  }
  return {samples, 0.25};
}

TEST(RobotErrors, JacobianOfTheAzimuthIsRight) {
  const OdometryWindow nearby = steadyTravel(0.1, 0.25);
  Draws draws;
  for (int i = 0; i < 50; ++i) {
    WholeState x;
    const Eigen::Vector2d light(draws.between(0.5, 3.0), draws.between(-3.0, 3.0));
    const Eigen::Vector3d mount(draws.between(-0.2, 0.2), draws.between(-0.2, 0.2),
                                draws.between(-kPi, kPi));
    x << mount, draws.errors().head<kWholeErrors>(), light, -light;
    const int seen = i % kLights;
    for (int k = 0; k < kLights; ++k) x(kMountSize + heightAt(k)) = draws.between(-0.5, 0.5);
    for (const auto& expect : {expectAzimuth, expectElevation}) {
      const auto angle = [&](const WholeState& at) {
        return Eigen::Matrix<double, 1, 1>(expect(kWhole, at, seen, nearby).angle_rad);
      };
      auto numerical = numericalJacobian<1, kWholeSize>(angle, x, {0});
      // By the wheels it is of second order, offset times scale, and left out.
      numerical.segment<3>(kMountSize + 1).setZero();
      const Eigen::Matrix<double, 1, kWholeSize> J = expect(kWhole, x, seen, nearby).J_angle_state;
      EXPECT_LT(largestDifference(J, numerical), kJacobianTolerance);
    }
  }
}

TEST(RobotErrors, ALateBearingIsThatOfAnEarlierPose) {
  const double left_mps = 0.1;
  const double right_mps = 0.25;
  const double late_s = 0.08;
  const Pose2 stamp_from_moment =
      arcFromWheels({-late_s * left_mps, -late_s * right_mps}, 0.25).start_from_end;
  const Vector5 state = (Vector5() << 1.0, 0.5, 0.1, -0.05, 0.3).finished();
  Vector5 at_moment = state;
  at_moment.head<2>() = stamp_from_moment.inverse() * Eigen::Vector2d(state.head<2>());
  ErrorVector errors = ErrorVector::Zero();
  errors(placeOf<TimeOffset>()) = late_s;
  Observation late;
  late.azimuth_rad = azimuthFromCartesian(at_moment).azimuth_rad;
  late.nearby = steadyTravel(left_mps, right_mps);
  EXPECT_NEAR(residualOf(late, state, errors), 0.0, 1e-12);
}

TEST(OdometryWindow, IsLinearBetweenSamplesAndGoesOnBeyondThem) {
  const OdometryWindow nearby = steadyTravel(0.1, -0.2);
  for (double time_s : {-1.0, -0.3, -0.0137, 0.0, 0.01, 0.2, 0.7}) {
    EXPECT_NEAR(nearby.travelTo(time_s).left_m, 0.1 * time_s, 1e-12) << time_s;
    EXPECT_NEAR(nearby.travelTo(time_s).right_m, -0.2 * time_s, 1e-12) << time_s;
    EXPECT_NEAR(nearby.speedsAt(time_s).left_mps, 0.1, 1e-12) << time_s;
  }
  EXPECT_EQ(OdometryWindow().travelTo(0.3).left_m, 0.0);
}

SimulatedCase imperfectCase(std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  makeImperfect(simulated, {0.05, 0.01, 0.01, 0.0, 0.0, 0.02}, seed);
  simulated.looked_for = usualErrors();
  return simulated;
}

// From nothing, with 50 ms, 1 % ratio and 1 % scale, the start is found, and it is as good as its
// covariance says: as a statistic over runs.
TEST(RobotErrors, StartFromNothingFindsALateAndUnequalRobot) {
  constexpr int kRuns = 12;
  double nees = 0.0;
  int ready = 0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = imperfectCase(static_cast<std::uint64_t>(seed));
    simulated.duration_s = 40.0;
    const ObservationRun run = simulate(simulated);
    InitializerConfig config;
    config.batch.errors = simulated.looked_for;
    const StartAttempt attempt = findStart(run.observations, config);
    if (!attempt.ready()) continue;
    ++ready;
    nees += mountChiSquare(attempt.estimate.cartesian(), run.truth.back());
    constexpr double kSigmas = 4.0;
    const ErrorVector robot_error = attempt.estimate.errors().mean - trueErrors(simulated);
    for (int i = 0; i < 4; ++i) {
      EXPECT_LT(std::abs(robot_error(i)),
                kSigmas * std::sqrt(attempt.estimate.errors().covariance(i, i)))
          << errorQuantities()[static_cast<std::size_t>(i)].name << ", seed " << seed;
    }
  }
  EXPECT_GE(ready, kRuns - 1);
  EXPECT_LT(nees, chiSquareQuantile(0.999, 3.0 * ready));
}

// The same robot without the blocks: the plain model is wrong and its covariance does not know.
// (Where slips may be given up, it gives up so many motions that its covariance tells.)
TEST(RobotErrors, ThePlainModelIsWrongAboutALateRobot) {
  const SimulatedCase simulated = imperfectCase(1);
  const ObservationRun run = simulate(simulated);
  BatchConfig config;
  config.slip_gain = 0.0;
  const RecordStart start{run.truth.back(), run.observations.size() - 1};
  const BatchEstimate plain = BatchEstimator(config).estimate(run.observations, start);
  constexpr double kWrong = 25.0;
  EXPECT_GT(mountChiSquare(plain.last.cartesian(), run.truth.back()), kWrong);
  config.errors = simulated.looked_for;
  const BatchEstimate full = BatchEstimator(config).estimate(run.observations, start);
  EXPECT_LT(mountChiSquare(full.last.cartesian(), run.truth.back()), chiSquareQuantile(0.999, 3.0));
}

// There the cost has a crease: the wheels' travel between two samples is linear.
TEST(RobotErrors, AnOffsetOnASampleOfTheWheelsSettles) {
  constexpr int kRuns = 100;
  constexpr double kOffset_s = 2.0 * OdometryWindow::kStep_s;
  double nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = paperCase(seed);
    makeImperfect(simulated, {kOffset_s, 0.0, 0.0, 0.0, 0.0, 0.0}, seed);
    const ObservationRun run = simulate(simulated);
    BatchConfig config;
    config.errors = usualErrors();
    const BatchEstimate fit = BatchEstimator(config).estimate(
        run.observations, {run.truth.back(), run.observations.size() - 1});
    EXPECT_TRUE(fit.converged) << seed;
    nees += mountChiSquare(fit.last.cartesian(), run.truth.back());
  }
  EXPECT_LT(nees, chiSquareQuantile(0.999, 3.0 * kRuns));
}

// The separation is what lengths are measured by: data alone do not tell it, and the report says
// so; time offset and scales are told.
TEST(RobotErrors, ReportSaysWhatTheDataTell) {
  const SimulatedCase simulated = imperfectCase(2);
  const ObservationRun run = simulate(simulated);
  BatchConfig config;
  config.errors = simulated.looked_for;
  config.errors.setBlock("wheel_separation", 0.005);
  const BatchEstimate batch = BatchEstimator(config).estimate(
      run.observations, {run.truth.back(), run.observations.size() - 1});
  const std::vector<BlockReport> reports = reportBlocks(config.errors, batch.last.errors());
  ASSERT_EQ(reports.size(), 5U);
  EXPECT_EQ(reports[0].status, BlockStatus::kEstimated) << reports[0].name;
  EXPECT_EQ(reports[1].status, BlockStatus::kEstimated) << reports[1].name;
  EXPECT_EQ(reports[2].status, BlockStatus::kHeldAtPrior) << reports[2].name;
  EXPECT_NE(reports[2].note.find("metric scale"), std::string::npos);
  EXPECT_EQ(reports[3].status, BlockStatus::kOff) << reports[3].name;
  ASSERT_EQ(reports[3].numbers.size(), 3U);
  for (const ReportedNumber& number : reports[3].numbers) EXPECT_EQ(number.value, 0.0);
  EXPECT_EQ(reports[4].status, BlockStatus::kOff) << reports[4].name;
  EXPECT_TRUE(reports[4].note.empty());
}

// What the doubt of the stated wheels adds to their variances is nothing that the data lack.
TEST(RobotErrors, WheelsThatTheDataContradictAreEstimatedAllTheSame) {
  ErrorPriors priors;
  priors.setBlock(WheelScales::kName, 0.03);
  priors.setBlock(WheelSeparation::kName, 0.01);
  ErrorEstimate estimate;  // of a separation that is 10 % less than stated
  estimate.mean.segment<2>(placeOf<WheelScales>()).setConstant(0.082);
  estimate.mean(placeOf<WheelSeparation>()) = -0.018;
  constexpr double kLeft = 0.18;  // of the scales' prior variance: as the separation is known
  estimate.covariance.block<2, 2>(placeOf<WheelScales>(), placeOf<WheelScales>())
      .setConstant(kLeft * 0.03 * 0.03 * (1.0 + doubtOfLengths(estimate, priors)));
  EXPECT_EQ(reportBlocks(priors, estimate)[1].status, BlockStatus::kEstimated);
}

TEST(RobotErrors, WhatNearnessLeavesOpenIsThePlaceOfTheSensor) {
  const StateEstimate known = StateEstimate::zero({0, 1});
  const StateEstimate open = withNearness(known, 0.02);
  const Eigen::Vector3d variance = open.mount().covariance.diagonal();
  EXPECT_NEAR(variance.x(), 4e-4, 1e-12);
  EXPECT_NEAR(variance.y(), 4e-4, 1e-12);
  EXPECT_EQ(variance.z(), 0.0);
}

TEST(RobotErrors, WhatNearnessLeavesOpenIsTakenBackAsItWasAdded) {
  StateEstimate known = StateEstimate::zero({0, 1});
  known.covariance.diagonal() << 1e-4, 2e-4, 3e-4, 4e-4, 5e-4;
  const StateEstimate back = withoutNearness(withNearness(known, 0.02), 0.02);
  EXPECT_LT((back.covariance - known.covariance).norm(), 1e-15);
}

TEST(RobotErrors, PriorsAreNamedAndChecked) {
  ErrorPriors priors;
  EXPECT_EQ(errorsInUse(priors), 0);
  priors.setBlock("time_offset", 0.1);
  EXPECT_EQ(errorsInUse(priors), 1);
  priors.setBlock("wheel_separation", 0.1);
  EXPECT_EQ(errorsInUse(priors), kWheelErrors);
  priors.setBlock("mirror_harmonic", 0.03);
  EXPECT_EQ(errorsInUse(priors), placeOf<SensorTilt>());
  priors.setBlock("sensor_tilt", 0.035);
  EXPECT_EQ(errorsInUse(priors), heightAt(1));
  EXPECT_EQ(errorsInUse(priors, kMostLights), kErrorCount);
  EXPECT_THROW(priors.setBlock("wobble", 0.1), std::invalid_argument);
  priors.setBlock("wheel_scales", -1.0);
  const std::vector<std::string> errors = errorsOf(priors);
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_NE(errors[0].find("errors/wheel_scales_stddev"), std::string::npos);
}

}  // namespace
}  // namespace bearing_calibration::core
