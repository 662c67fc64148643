// The simulated robot's wheels: encoders and trajectories against closed forms and statistics.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/simulation/robot_sensors.h"
#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSeparation_m = 0.25;
/// A test at this level fails by chance in one of 1000 seeds; the seeds are fixed.
constexpr double kTail = 0.0005;

EncoderConfig encoderConfig(double ticks_per_revolution, int counter_bits) {
  EncoderConfig config;
  config.drive = {kSeparation_m, 0.05, 0.05, ticks_per_revolution, counter_bits, 1.0};
  return config;
}

/// Expects sum / variance to be a chi-square variable with `n` degrees of freedom.
void expectChiSquare(double sum_of_squares, double variance, int n) {
  EXPECT_GT(sum_of_squares / variance, chiSquareQuantile(kTail, n)) << "too little noise";
  EXPECT_LT(sum_of_squares / variance, chiSquareQuantile(1.0 - kTail, n)) << "too much noise";
}

TEST(WrapCounter, KeepsTheCountModuloThePeriodAndStaysInRange) {
  for (int bits : {8, 16, 32}) {
    const std::int64_t period = std::int64_t{1} << bits;
    for (std::int64_t near : {-2 * period, -period, -period / 2, std::int64_t{0}, period / 2}) {
      for (std::int64_t count = near - 3; count <= near + 3; ++count) {
        const std::int64_t with_sign = wrapCounter(count, bits, true);
        const std::int64_t without = wrapCounter(count, bits, false);
        EXPECT_EQ((with_sign - count) % period, 0) << count << " at " << bits << " bits";
        EXPECT_EQ((without - count) % period, 0) << count << " at " << bits << " bits";
        EXPECT_TRUE(with_sign >= -period / 2 && with_sign < period / 2) << with_sign;
        EXPECT_TRUE(without >= 0 && without < period) << without;
      }
    }
  }
  EXPECT_EQ(wrapCounter(INT64_MIN, 64, true), INT64_MIN);
}

TEST(WheelEncoders, CountWholeTicksWithoutLosingAny) {
  WheelEncoders encoders(encoderConfig(100.0, 64), 1);
  const double meters_per_tick = 2.0 * kPi * 0.05 / 100.0;
  double left_m = 0.0;
  double right_m = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const WheelDisplacement step{0.00071 * std::sin(0.1 * i), 0.0013};
    left_m += step.left_m;
    right_m += step.right_m;
    encoders.roll(step);
    const WheelCounts ticks = encoders.read(Stamp());
    EXPECT_EQ(static_cast<double>(ticks.left_ticks), std::floor(left_m / meters_per_tick));
    EXPECT_EQ(static_cast<double>(ticks.right_ticks), std::floor(right_m / meters_per_tick));
  }
}

TEST(WheelEncoders, WrapInBothDirections) {
  for (bool is_signed : {true, false}) {
    EncoderConfig config = encoderConfig(1000.0, 8);
    config.signed_counters = is_signed;
    config.left_start_ticks = 3;
    WheelEncoders encoders(config, 1);
    const double tick_m = config.drive.leftMetersPerTick();
    std::int64_t count = 3;
    for (int i = 0; i < 1200; ++i) {
      const int direction = i < 400 ? 1 : -1;
      encoders.roll({direction * tick_m, 0.0});
      count += direction;
      const std::int64_t reading = encoders.read(Stamp()).left_ticks;
      // One tick of slack: the running sum of floating-point steps may lie just below a whole tick.
      const std::int64_t error = wrapCounter(reading - count, 8, true);
      EXPECT_TRUE(error == 0 || error == -1) << reading << " for a count of " << count;
    }
  }
}

TEST(WheelEncoders, ErrorsOfChongAndKleemanGrowWithTheDistanceRolled) {
  constexpr int kRuns = 400;
  constexpr int kSteps = 50;
  constexpr double kStep_m = 0.002;
  EncoderConfig config = encoderConfig(1e9, 64);  // ticks of 0.3 nm: quantisation does not count
  config.noise.independent_k_m = 1e-6;
  double left_sum = 0.0;
  double right_sum = 0.0;
  double difference_sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    WheelEncoders encoders(config, static_cast<std::uint64_t>(run));
    for (int i = 0; i < kSteps; ++i) encoders.roll({kStep_m, -2.0 * kStep_m});
    const WheelCounts ticks = encoders.read(Stamp());
    const double left_error =
        static_cast<double>(ticks.left_ticks) * config.drive.leftMetersPerTick() - kSteps * kStep_m;
    const double right_error =
        static_cast<double>(ticks.right_ticks) * config.drive.rightMetersPerTick() +
        2.0 * kSteps * kStep_m;
    left_sum += left_error * left_error;
    right_sum += right_error * right_error;
    difference_sum += (left_error - right_error) * (left_error - right_error);
  }
  const double variance = 1e-6 * kSteps * kStep_m;  // K times the distance, eq. 22
  expectChiSquare(left_sum, variance, kRuns);
  expectChiSquare(right_sum, 2.0 * variance, kRuns);
  expectChiSquare(difference_sum, 3.0 * variance, kRuns);  // only when they are independent
}

TEST(WheelEncoders, SharedErrorsLeaveTheTurnAlone) {
  constexpr int kRuns = 400;
  EncoderConfig config = encoderConfig(1e9, 64);
  config.noise.common_k_m = 1e-4;
  const double tick_m = config.drive.leftMetersPerTick();
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    WheelEncoders encoders(config, static_cast<std::uint64_t>(run));
    encoders.roll({0.3, 0.1});
    const WheelCounts ticks = encoders.read(Stamp());
    const double left_error = static_cast<double>(ticks.left_ticks) * tick_m - 0.3;
    const double right_error = static_cast<double>(ticks.right_ticks) * tick_m - 0.1;
    EXPECT_NEAR(left_error, right_error, 2.0 * tick_m);
    sum += left_error * left_error;
  }
  expectChiSquare(sum, 1e-4 * 0.2, kRuns);  // the centre moved by 0.2 m
}

TEST(WheelEncoders, LargerWheelsTurnLess) {
  EncoderConfig config = encoderConfig(1e6, 64);
  config.left_radius_factor = 1.25;
  WheelEncoders encoders(config, 1);
  encoders.roll({1.0, 1.0});
  const WheelCounts ticks = encoders.read(Stamp());
  EXPECT_NEAR(static_cast<double>(ticks.left_ticks) * 1.25, static_cast<double>(ticks.right_ticks),
              2.0);
}

TEST(WheelEncoders, ListEveryWrongValue) {
  EncoderConfig config = encoderConfig(-1.0, 12);
  config.noise.independent_k_m = -1.0;
  config.right_radius_factor = 0.0;
  EXPECT_EQ(errorsOf(config).size(), 4U);
  EXPECT_THROW(WheelEncoders(config, 1), std::invalid_argument);
}

/// Where a robot ends that drives `config` for `duration_s`.
Pose2 endOf(const TrajectoryConfig& config, double duration_s, double step_s) {
  const auto trajectory = makeTrajectory(config, kSeparation_m);
  Pose2 start_from_base;
  for (int i = 0; i < std::lround(duration_s / step_s); ++i) {
    start_from_base =
        start_from_base * arcFromWheels(trajectory(step_s), kSeparation_m).start_from_end;
  }
  return start_from_base;
}

void expectPose(const Pose2& pose, double x_m, double y_m, double yaw_rad, double tolerance) {
  EXPECT_NEAR(pose.position_m.x(), x_m, tolerance);
  EXPECT_NEAR(pose.position_m.y(), y_m, tolerance);
  EXPECT_NEAR(wrapAngle(pose.yaw_rad - yaw_rad), 0.0, tolerance);
}

// The faster wheel at radius + b/2 runs at v, so the heading turns at v / (radius + b/2).
TEST(Trajectory, CircleIsExactAtAnyStep) {
  TrajectoryConfig config;
  config.kind = TrajectoryConfig::Kind::kCircle;
  for (double step_s : {0.001, 0.05, 1.0}) {
    const double angle = 10.0 * 0.2 / (0.5 + 0.5 * kSeparation_m);
    expectPose(endOf(config, 10.0, step_s), 0.5 * std::sin(angle), 0.5 * (1.0 - std::cos(angle)),
               angle, 1e-9);
  }
}

// 1 m at 0.2 m/s, then 450 degrees: each wheel rolls b/2 * 2.5 pi.
TEST(Trajectory, DanceIsStraightThenSpins) {
  const TrajectoryConfig config;
  expectPose(endOf(config, 5.0, 0.01), 1.0, 0.0, 0.0, 1e-9);
  const double spin_s = 0.5 * kSeparation_m * 2.5 * kPi / 0.2;
  expectPose(endOf(config, 5.0 + spin_s, (5.0 + spin_s) / 991.0), 1.0, 0.0, 0.5 * kPi, 1e-2);
  // Four times around is the square's start again; the step that holds a change of segment is one
  // arc, which moves the corner by less than half a step's way.
  expectPose(endOf(config, 4.0 * (5.0 + spin_s), 4.0 * (5.0 + spin_s) / 4000.0), 0.0, 0.0, 0.0,
             4e-3);
}

TEST(Trajectory, SinusoidSwingsTheHeading) {
  TrajectoryConfig config;
  config.kind = TrajectoryConfig::Kind::kSinusoid;
  for (double time_s : {1.0, 3.7, 11.0, 20.0}) {
    const double heading = kPi / 3.0 * std::sin(2.0 * kPi * time_s / 15.0);
    EXPECT_NEAR(wrapAngle(endOf(config, time_s, 0.01).yaw_rad - heading), 0.0, 1e-9);
  }
}

TEST(Trajectory, RandomStepsHaveThePapersVariance) {
  TrajectoryConfig config;
  config.kind = TrajectoryConfig::Kind::kRandom;
  const auto trajectory = makeTrajectory(config, kSeparation_m);
  constexpr int kSteps = 4000;
  const double mean_m = 0.2 * 0.01;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const WheelDisplacement wheels = trajectory(0.01);
    for (double displacement_m : {wheels.left_m, wheels.right_m}) {
      sum += displacement_m - mean_m;
      sum_of_squares += (displacement_m - mean_m) * (displacement_m - mean_m);
    }
  }
  const double variance = 0.01 * 0.2 * 0.01;  // section V-A, in the paper's own numbers
  expectChiSquare(sum_of_squares, variance, 2 * kSteps);
  expectChiSquare(sum * sum / (2.0 * kSteps), variance, 1);
}

TEST(Trajectory, StandingBackAndForthAndSpinComeBack) {
  TrajectoryConfig config;
  config.kind = TrajectoryConfig::Kind::kStanding;
  expectPose(endOf(config, 10.0, 0.01), 0.0, 0.0, 0.0, 0.0);
  config.kind = TrajectoryConfig::Kind::kBackAndForth;
  expectPose(endOf(config, 5.0, 0.01), 1.0, 0.0, 0.0, 1e-9);
  expectPose(endOf(config, 10.0, 0.01), 0.0, 0.0, 0.0, 1e-9);
  config.kind = TrajectoryConfig::Kind::kLine;
  expectPose(endOf(config, 12.0, 0.01), 2.4, 0.0, 0.0, 1e-9);
  config.kind = TrajectoryConfig::Kind::kSpin;
  expectPose(endOf(config, 2.0, 0.01), 0.0, 0.0, 2.0 * 2.0 * 0.2 / kSeparation_m, 1e-9);
}

TEST(Trajectory, EveryKindHasAName) {
  const auto last = static_cast<std::size_t>(TrajectoryConfig::Kind::kSpin);
  EXPECT_EQ(trajectoryNames().size(), last + 1);
  EXPECT_EQ(trajectoryNames().at(last), "spin");
}

TEST(Trajectory, WrongMeasuresAreListed) {
  TrajectoryConfig config;
  config.wheel_speed_mps = 0.0;
  config.sinusoid_period_s = -1.0;
  EXPECT_EQ(errorsOf(config).size(), 2U);
  EXPECT_THROW(makeTrajectory(config, kSeparation_m), std::invalid_argument);
  EXPECT_THROW(makeTrajectory(TrajectoryConfig(), 0.0), std::invalid_argument);
}

TEST(CommandedTrajectory, StopsWhenNobodyCommandsAnyMore) {
  CommandedTrajectory trajectory(kSeparation_m, 1.0, 0.5);
  EXPECT_EQ(trajectory.advance(0.1).left_m, 0.0);
  trajectory.command(0.2, 0.4);
  double left_m = 0.0;
  double right_m = 0.0;
  for (int i = 0; i < 100; ++i) {
    const WheelDisplacement wheels = trajectory.advance(0.03);
    left_m += wheels.left_m;
    right_m += wheels.right_m;
  }
  EXPECT_NEAR(left_m, 0.5 * (0.2 - 0.4 * 0.5 * kSeparation_m), 1e-12);
  EXPECT_NEAR(right_m, 0.5 * (0.2 + 0.4 * 0.5 * kSeparation_m), 1e-12);
}

TEST(CommandedTrajectory, KeepsTheCurvatureOfACommandThatIsTooFast) {
  CommandedTrajectory trajectory(kSeparation_m, 0.3, 1.0);
  trajectory.command(2.0, 4.0);
  const WheelDisplacement wheels = trajectory.advance(0.1);
  EXPECT_NEAR(wheels.right_m, 0.03, 1e-12);
  EXPECT_NEAR(wheels.left_m / wheels.right_m, (2.0 - 0.5) / (2.0 + 0.5), 1e-12);
  EXPECT_THROW(trajectory.command(NAN, 0.0), std::invalid_argument);
}

TEST(Trajectory, LimitedOneStandsStillAtItsEnd) {
  TrajectoryConfig config;
  config.kind = TrajectoryConfig::Kind::kLine;
  const Trajectory trajectory = limitedTrajectory(makeTrajectory(config, kSeparation_m), 1.05);
  double left_m = 0.0;
  for (int i = 0; i < 30; ++i) left_m += trajectory(0.1).left_m;
  EXPECT_NEAR(left_m, 1.05 * 0.2, 1e-12);
}

}  // namespace
}  // namespace bearing_calibration::core
