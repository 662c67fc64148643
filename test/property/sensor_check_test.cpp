#include "bearing_calibration/output/sensor_check.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

constexpr int kRuns = 60;
constexpr double kStop_s = 8.0;
constexpr double kTurn_s = 16.0;
constexpr double kSpin_mps = 0.1;  // of each wheel: 0.8 rad/s of the paper's robot

/// Stops, and two turns on the spot each way.
std::vector<Observation> stopAndTurn(const SimulatedCase& simulated) {
  const Trajectory trajectory = segmentTrajectory({{0.0, 0.0, kStop_s},
                                                   {-kSpin_mps, kSpin_mps, kTurn_s},
                                                   {0.0, 0.0, kStop_s},
                                                   {kSpin_mps, -kSpin_mps, kTurn_s}});
  return simulateAlong(simulated, trajectory).observations;
}

SimulatedCase someCase(std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = 2.0 * (kStop_s + kTurn_s);
  return simulated;
}

/// Mean of so many squares that are chi-square(1), 99.9 %.
void expectMeanOfChiSquares(double sum, int count, const char* what) {
  EXPECT_GT(sum, chiSquareQuantile(0.0005, count)) << what << ": more certain than it says";
  EXPECT_LT(sum, chiSquareQuantile(0.9995, count)) << what << ": less certain than it says";
}

TEST(SensorCheck, LatencyAndTurnAreFoundAsWellAsTheySay) {
  double late_nees = 0.0;
  double more_nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = someCase(seed);
    ImperfectRobot imperfect;
    imperfect.time_offset_s = 0.08;
    imperfect.scale = 0.02;
    imperfect.harmonic_rad = 0.03;
    makeImperfect(simulated, imperfect, seed);
    const SensorCheck check = checkSensor(stopAndTurn(simulated));
    ASSERT_TRUE(check.turning);
    const TurningBearings& turning = *check.turning;
    EXPECT_TRUE(turning.tells_latency);
    late_nees += std::pow((turning.late_s.value - 0.08) / turning.late_s.stddev, 2);
    more_nees += std::pow((turning.more_turn.value - 0.02) / turning.more_turn.stddev, 2);
  }
  expectMeanOfChiSquares(late_nees, kRuns, "latency");
  expectMeanOfChiSquares(more_nees, kRuns, "turn");
}

void expectNoiseIsFound(double correlation) {
  const double interval_s = 0.1;
  double stddev_sum = 0.0;
  double turning_sum = 0.0;
  double time_sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = someCase(seed);
    simulated.robot.sensor.correlation = correlation;
    const double stddev_rad = simulated.robot.sensor.stddev_rad;
    const SensorCheck check = checkSensor(stopAndTurn(simulated));
    ASSERT_TRUE(check.standing && check.turning);
    EXPECT_EQ(check.standing->stops, 2);
    EXPECT_NEAR(check.standing->stated_stddev_rad, stddev_rad, 1e-9);
    stddev_sum += check.standing->stddev_rad / stddev_rad / kRuns;
    turning_sum += check.turning->stddev_rad / stddev_rad / kRuns;
    time_sum += check.standing->correlation_time_s / kRuns;
  }
  // 160 bearings in a run, of which correlated ones count for fewer
  const double independent =
      160.0 * (1.0 - correlation * correlation) / (1.0 + correlation * correlation);
  const double stddev = 1.0 / std::sqrt(2.0 * independent * kRuns);
  EXPECT_NEAR(stddev_sum, 1.0, 4.0 * stddev + 0.01);
  EXPECT_NEAR(turning_sum, 1.0, 4.0 * stddev + 0.03);
  if (correlation > 0.0) {
    EXPECT_NEAR(time_sum, -interval_s / std::log(correlation), 0.1 * interval_s);
  } else {
    EXPECT_LT(time_sum, 0.05 * interval_s);
  }
}

TEST(SensorCheck, NoiseOfARobotThatStands) { expectNoiseIsFound(0.0); }
TEST(SensorCheck, NoiseThatIsCorrelatedInTime) { expectNoiseIsFound(0.7); }

// The mean of a short stop takes a part of correlated noise with it: of 20 bearings 15 %.
TEST(SensorCheck, ShortStopsScatterByAsMuch) {
  constexpr double kCorrelation = 0.7;
  double stddev_sum = 0.0;
  double time_sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = someCase(seed);
    simulated.robot.sensor.correlation = kCorrelation;
    const std::vector<Observation> observations =
        simulateAlong(simulated, segmentTrajectory({{0.0, 0.0, 2.0}, {0.2, 0.2, 0.5}}))
            .observations;
    const SensorCheck check = checkSensor(observations);
    ASSERT_TRUE(check.standing);
    EXPECT_GT(check.standing->stops, 15);
    stddev_sum += check.standing->stddev_rad / simulated.robot.sensor.stddev_rad / kRuns;
    time_sum += check.standing->correlation_time_s / kRuns;
  }
  EXPECT_NEAR(stddev_sum, 1.0, 0.05);
  EXPECT_NEAR(time_sum, -0.1 / std::log(kCorrelation), 0.03);
}

TEST(SensorCheck, OutliersAreCountedAndLeftOut) {
  SimulatedCase simulated = someCase(1);
  simulated.robot.sensor.outlier_probability = 0.1;
  const SensorCheck check = checkSensor(stopAndTurn(simulated));
  ASSERT_TRUE(check.standing);
  EXPECT_NEAR(check.standing->outlier_share, 0.1, 4.0 * std::sqrt(0.1 * 0.9 / 160.0));
  EXPECT_NEAR(check.standing->stddev_rad / simulated.robot.sensor.stddev_rad, 1.0, 0.25);
  ASSERT_TRUE(check.turning);
  EXPECT_NEAR(check.turning->stddev_rad / simulated.robot.sensor.stddev_rad, 1.0, 0.25);
}

// Between two recordings in one bag the robot may have been carried elsewhere.
TEST(SensorCheck, WhatLiesBetweenTwoRecordingsIsNoStop) {
  SimulatedCase simulated = someCase(1);
  const Trajectory trajectory = segmentTrajectory({{0.0, 0.0, kStop_s}});
  simulated.duration_s = kStop_s;
  std::vector<Observation> both = simulateAlong(simulated, trajectory).observations;
  const std::size_t first = both.size();
  for (Observation observation : std::vector<Observation>(both)) {
    observation.stamp += durationFromSeconds(60.0);
    observation.azimuth_rad += 0.5;
    both.push_back(observation);
  }
  ASSERT_EQ(both[first].motion.distance_m, 0.0);
  const SensorCheck check = checkSensor(both);
  ASSERT_TRUE(check.standing);
  EXPECT_EQ(check.standing->stops, 2);
  EXPECT_NEAR(check.standing->stddev_rad / simulated.robot.sensor.stddev_rad, 1.0, 0.25);
}

// A sensor of steps of two standard deviations measures the same most of the time.
TEST(SensorCheck, ACoarseSensorScatters) {
  const SimulatedCase simulated = someCase(1);
  const double step_rad = 2.0 * simulated.robot.sensor.stddev_rad;
  std::vector<Observation> observations = stopAndTurn(simulated);
  for (Observation& observation : observations)
    observation.azimuth_rad = step_rad * std::round(observation.azimuth_rad / step_rad);
  const SensorCheck check = checkSensor(observations);
  ASSERT_TRUE(check.standing);
  // Sheppard: a twelfth of the step's square more
  const double expected_rad =
      std::sqrt(std::pow(simulated.robot.sensor.stddev_rad, 2) + step_rad * step_rad / 12.0);
  EXPECT_NEAR(check.standing->stddev_rad / expected_rad, 1.0, 0.25);
  EXPECT_NEAR(check.standing->outlier_share, 0.0, 0.01);
}

TEST(SensorCheck, NothingIsSaidOfWhatTheRobotDidNotDo) {
  const SimulatedCase simulated = someCase(1);
  const SensorCheck line =
      checkSensor(simulateAlong(simulated, segmentTrajectory({{0.1, 0.1, 100.0}})).observations);
  EXPECT_FALSE(line.standing || line.turning);
  std::vector<Observation> spin =
      simulateAlong(simulated, segmentTrajectory({{-0.1, 0.1, 100.0}})).observations;
  spin.erase(spin.begin(), spin.begin() + 10);  // before which it stood
  const SensorCheck constant_spin = checkSensor(spin);
  ASSERT_TRUE(constant_spin.turning);
  EXPECT_FALSE(constant_spin.turning->tells_latency);
  EXPECT_FALSE(checkSensor({}).standing);
}

}  // namespace
}  // namespace bearing_calibration::core
