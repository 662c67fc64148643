// The simulated robot as a whole: bearings, faults, stamps, and what a seed determines.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {
namespace {

/// A test at this level fails by chance in one of 1000 seeds; the seeds are fixed.
constexpr double kTail = 0.0005;
/// The two-sided Gaussian bound of the same level.
const double kGaussianBound = std::sqrt(chiSquareQuantile(1.0 - 2.0 * kTail, 1.0));

/// The paper's robot (section V-A) on its second trajectory, the light at the origin.
RobotConfig paperRobot() {
  RobotConfig config;
  config.encoders.drive = {0.25, 0.05, 0.05, 4096.0, 32, 1.0};
  config.encoders.noise.independent_k_m = 1e-6;
  config.base_from_sensor = {rotation2(kPi / 6.0) * Eigen::Vector2d(0.1, 0.0), kPi / 3.0};
  config.world_from_start = {{2.0, 0.0}, 0.5 * kPi};
  config.sensor.stddev_rad = radiansFromDegrees(1.0);
  return config;
}

RobotSimulator simulatorOf(const RobotConfig& config, std::vector<Light> lights = {Light()},
                           const TrajectoryConfig& trajectory = {}) {
  return RobotSimulator(config, std::move(lights),
                        makeTrajectory(trajectory, config.encoders.drive.wheel_separation_m));
}

SimulatedRecord recordOf(const RobotConfig& config, double duration_s = 100.0) {
  RobotSimulator simulator = simulatorOf(config);
  return record(&simulator, duration_s);
}

/// Azimuth errors of one light along a record.
std::vector<double> azimuthErrors(const RobotConfig& config, const SimulatedRecord& record) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    const Pose2 world_from_sensor = record.world_from_base[i] * config.base_from_sensor;
    for (const Bearing& bearing : record.bearings[i].candidates) {
      errors.push_back(wrapAngle(bearing.azimuth_rad - azimuthOf(Light(), world_from_sensor)));
    }
  }
  return errors;
}

// Equation (8) of the paper, with the light at the origin.
TEST(AzimuthOf, AgreesWithThePapersBearing) {
  for (int i = 0; i < 50; ++i) {
    const double D = 0.5 + 0.1 * i;
    const double direction = 0.7 * i;  // from the light to the robot
    const double theta = 1.3 * i;
    const double phi = 0.3 * i;
    const double rho = 0.02 * i;
    const double psi = -0.9 * i;
    const Pose2 world_from_base{D * Eigen::Vector2d(std::cos(direction), std::sin(direction)),
                                wrapAngle(direction + theta)};
    const Pose2 base_from_sensor{rho * Eigen::Vector2d(std::cos(phi), std::sin(phi)),
                                 wrapAngle(phi + psi)};
    const double beta = std::atan2(-rho * std::sin(theta + phi), -D - rho * std::cos(theta + phi)) -
                        theta - phi - psi;
    EXPECT_NEAR(wrapAngle(azimuthOf(Light(), world_from_base * base_from_sensor) - beta), 0.0,
                1e-12);
  }
}

TEST(RobotSimulator, ReadsWhenDueFromTheStartOn) {
  RobotConfig config = paperRobot();
  config.steps_per_reading = 2;
  const SimulatedRecord record = recordOf(config, 1.0);
  ASSERT_EQ(record.ticks.size(), 51U);
  ASSERT_EQ(record.bearings.size(), 11U);
  EXPECT_EQ(record.ticks.front().stamp, config.start);
  for (std::size_t i = 1; i < record.ticks.size(); ++i) {
    EXPECT_EQ(record.ticks[i].stamp - record.ticks[i - 1].stamp, durationFromSeconds(0.02));
  }
  EXPECT_EQ(record.bearings.back().stamp, config.start + durationFromSeconds(1.0));
}

TEST(RobotSimulator, AzimuthsHaveTheNoiseThatTheySay) {
  const RobotConfig config = paperRobot();
  const SimulatedRecord record = recordOf(config);
  const std::vector<double> errors = azimuthErrors(config, record);
  ASSERT_EQ(errors.size(), record.bearings.size());
  const double variance = record.bearings.front().candidates.front().azimuth_variance_rad2;
  EXPECT_NEAR(degreesFromRadians(std::sqrt(variance)), 1.0, 1e-9);
  double chi_square = 0.0;
  for (double error : errors) chi_square += error * error / variance;
  const double n = static_cast<double>(errors.size());
  EXPECT_GT(chi_square, chiSquareQuantile(kTail, n));
  EXPECT_LT(chi_square, chiSquareQuantile(1.0 - kTail, n));
}

TEST(RobotSimulator, CorrelatedNoiseHasTheLagOneCorrelationAskedFor) {
  RobotConfig config = paperRobot();
  config.sensor.correlation = 0.5;
  const std::vector<double> errors = azimuthErrors(config, recordOf(config, 1000.0));
  double square = 0.0;
  double product = 0.0;
  for (std::size_t i = 1; i < errors.size(); ++i) {
    square += errors[i] * errors[i];
    product += errors[i] * errors[i - 1];
  }
  // Bartlett: the estimate of an AR(1) process has the variance (1 - r^2) / n.
  const double stddev = std::sqrt((1.0 - 0.25) / static_cast<double>(errors.size()));
  EXPECT_NEAR(product / square, 0.5, kGaussianBound * stddev);
  // The variance stays: a sum of correlated squares has (1 + r^2) / (1 - r^2) times the spread.
  const double n = static_cast<double>(errors.size());
  const double spread = std::sqrt(2.0 / n * (1.0 + 0.25) / (1.0 - 0.25));
  EXPECT_NEAR(square / n / std::pow(radiansFromDegrees(1.0), 2), 1.0, kGaussianBound * spread);
}

TEST(RobotSimulator, OutliersAndMissesComeAtTheirRates) {
  RobotConfig config = paperRobot();
  config.sensor.outlier_probability = 0.2;
  config.sensor.miss_probability = 0.3;
  const SimulatedRecord record = recordOf(config, 300.0);
  const std::vector<double> errors = azimuthErrors(config, record);
  const double n = static_cast<double>(record.bearings.size());
  const double seen = static_cast<double>(errors.size());
  EXPECT_NEAR(seen / n, 0.7, kGaussianBound * std::sqrt(0.3 * 0.7 / n));
  // Uniform azimuths land within 5 sigma of the truth in 10 of 360 degrees.
  double far = 0.0;
  for (double error : errors) far += std::abs(degreesFromRadians(error)) > 5.0 ? 1.0 : 0.0;
  const double rate = 0.2 * 350.0 / 360.0;
  EXPECT_NEAR(far / seen, rate, kGaussianBound * std::sqrt(rate * (1.0 - rate) / seen));
}

// Rayleigh: for n uniform directions, twice the squared length of their sum over n is a chi-square
// variable with two degrees of freedom.
TEST(RobotSimulator, OutliersComeFromEveryDirection) {
  RobotConfig config = paperRobot();
  config.sensor.outlier_probability = 1.0;
  const SimulatedRecord record = recordOf(config);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const BearingSet& bearings : record.bearings) {
    const double azimuth = bearings.candidates.front().azimuth_rad;
    sum += Eigen::Vector2d(std::cos(azimuth), std::sin(azimuth));
  }
  const double n = static_cast<double>(record.bearings.size());
  EXPECT_LT(2.0 * sum.squaredNorm() / n, chiSquareQuantile(1.0 - 2.0 * kTail, 2.0));
}

TEST(RobotSimulator, SeedDeterminesEverythingAndOneNoiseLeavesTheOthersAlone) {
  const RobotConfig config = paperRobot();
  RobotConfig with_outliers = config;
  with_outliers.sensor.outlier_probability = 0.1;
  RobotConfig other_seed = config;
  other_seed.seed = 2;
  const SimulatedRecord first = recordOf(config);
  const SimulatedRecord again = recordOf(config);
  const SimulatedRecord outliers = recordOf(with_outliers);
  const SimulatedRecord other = recordOf(other_seed);
  int differing = 0;
  for (std::size_t i = 0; i < first.bearings.size(); ++i) {
    const double azimuth = first.bearings[i].candidates.front().azimuth_rad;
    EXPECT_EQ(azimuth, again.bearings[i].candidates.front().azimuth_rad);
    differing += azimuth != outliers.bearings[i].candidates.front().azimuth_rad ? 1 : 0;
  }
  EXPECT_GT(differing, 50);
  EXPECT_LT(differing, 150);
  bool is_same_ticks = true;
  for (std::size_t i = 0; i < first.ticks.size(); ++i) {
    EXPECT_EQ(first.ticks[i].right_ticks, outliers.ticks[i].right_ticks);
    is_same_ticks = is_same_ticks && first.ticks[i].right_ticks == other.ticks[i].right_ticks;
  }
  EXPECT_FALSE(is_same_ticks);
}

TEST(RobotSimulator, LateStampsMoveTheStampAndNothingElse) {
  RobotConfig late = paperRobot();
  late.stamp_latency_s = 0.08;
  const SimulatedRecord punctual_record = recordOf(paperRobot(), 10.0);
  const SimulatedRecord late_record = recordOf(late, 10.0);
  for (std::size_t i = 0; i < late_record.bearings.size(); ++i) {
    EXPECT_EQ(late_record.bearings[i].stamp - punctual_record.bearings[i].stamp,
              durationFromSeconds(0.08));
    EXPECT_EQ(late_record.bearings[i].candidates.front().azimuth_rad,
              punctual_record.bearings[i].candidates.front().azimuth_rad);
  }
}

TEST(RobotSimulator, SlippingWheelTurnsMoreThanItRolls) {
  RobotConfig config = paperRobot();
  config.encoders.noise.independent_k_m = 0.0;
  RobotConfig slipping = config;
  slipping.faults.slips = {{{1.0, 0.5}, WheelSlip::Wheel::kRight, 0.4}};
  const SimulatedRecord clean_record = recordOf(config, 3.0);
  const SimulatedRecord slip_record = recordOf(slipping, 3.0);
  EXPECT_EQ(slip_record.ticks[100].right_ticks, clean_record.ticks[100].right_ticks);
  const double excess_m = 0.4 * 0.5 * 0.2;  // of half a second at 0.2 m/s
  EXPECT_NEAR(static_cast<double>(slip_record.ticks.back().right_ticks -
                                  clean_record.ticks.back().right_ticks) *
                  config.encoders.drive.rightMetersPerTick(),
              excess_m, 2.0 * config.encoders.drive.rightMetersPerTick());
  EXPECT_EQ(slip_record.ticks.back().left_ticks, clean_record.ticks.back().left_ticks);
  EXPECT_EQ(slip_record.world_from_base.back().position_m,
            clean_record.world_from_base.back().position_m);
}

TEST(RobotSimulator, OcclusionsLostTicksAndResetsHappenWhenAsked) {
  RobotConfig config = paperRobot();
  config.encoders.left_start_ticks = 1000;
  config.faults.occlusions = {{1.0, 0.5}};
  config.faults.lost_ticks = {{2.0, 0.2}};
  config.faults.counter_resets_s = {3.0};
  const SimulatedRecord record = recordOf(config, 4.0);
  int empty = 0;
  for (const BearingSet& bearings : record.bearings) empty += bearings.candidates.empty() ? 1 : 0;
  EXPECT_EQ(empty, 5);
  EXPECT_EQ(record.ticks.size(), 401U - 20U);
  EXPECT_GT(record.ticks.front().left_ticks, 900);
  const WheelCounts& after_reset = record.ticks[300 - 20];
  EXPECT_EQ(secondsFromDuration(after_reset.stamp - config.start), 3.0);
  EXPECT_NEAR(static_cast<double>(after_reset.left_ticks), 0.0, 1.0);
}

TEST(RobotSimulator, WiderRobotTurnsLess) {
  RobotConfig config = paperRobot();
  config.separation_factor = 1.1;
  TrajectoryConfig spin;
  spin.kind = TrajectoryConfig::Kind::kSpin;
  RobotSimulator simulator = simulatorOf(config, {Light()}, spin);
  record(&simulator, 1.0);
  EXPECT_NEAR(wrapAngle(simulator.worldFromBase().yaw_rad - 0.5 * kPi), 0.4 / (1.1 * 0.25), 1e-9);
}

TEST(RobotSimulator, SeveralLightsAreToldApartOnlyWhenAsked) {
  RobotConfig config = paperRobot();
  Light second;
  second.position_m = {1.0, 3.0};
  for (bool identifies : {false, true}) {
    config.sensor.identifies_lights = identifies;
    RobotSimulator simulator = simulatorOf(config, {Light(), second});
    const auto bearings = simulator.readBearings();
    ASSERT_TRUE(bearings.has_value());
    ASSERT_EQ(bearings->candidates.size(), 2U);
    EXPECT_EQ(bearings->candidates[1].light_id, identifies ? 1 : kUnknownLight);
  }
}

TEST(RobotSimulator, ListsEveryWrongValue) {
  RobotConfig config = paperRobot();
  config.sensor.correlation = 1.0;
  config.step_s = 0.0;
  config.steps_per_reading = 0;
  config.start = Stamp();
  EXPECT_EQ(errorsOf(config).size(), 4U);
  EXPECT_THROW(simulatorOf(config), std::invalid_argument);
  EXPECT_THROW(RobotSimulator(paperRobot(), {Light()}, nullptr), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
