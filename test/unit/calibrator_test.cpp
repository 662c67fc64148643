#include "bearing_calibration/calibration/calibrator.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <optional>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/simulation/trajectory.h"
#include "bearing_calibration/track/mount_tracker.h"
#include "support/simulated_calibration.h"
#include "tools/study/default_calibration.h"

namespace bearing_calibration::core {
namespace {

using testing::calibratorConfig;
using testing::mountChiSquare;
using testing::paperRobot;
using testing::play;
using testing::simulate;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

CalibratorConfig configWith(FilterConfig::Parametrisation parametrisation) {
  CalibratorConfig config = calibratorConfig();
  config.filter.parametrisation = parametrisation;
  return config;
}

BearingSet bearingsAt(Stamp stamp, double azimuth_rad) {
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad;
  bearing.azimuth_variance_rad2 = 1e-4;
  return {stamp, {bearing}};
}

// Its covariance would be too small.
TEST(ThePapersFilter, IsRefusedTogetherWithErrorsOfTheRobot) {
  CalibratorConfig config = configWith(FilterConfig::Parametrisation::kPaper);
  EXPECT_TRUE(errorsOf(config).empty());
  config.initializer.batch.errors.setBlock(TimeOffset::kName, 0.1);
  ASSERT_EQ(errorsOf(config).size(), 1U);
  EXPECT_NE(errorsOf(config).front().find("filter/parametrisation"), std::string::npos);
}

class EitherParametrisation : public ::testing::TestWithParam<FilterConfig::Parametrisation> {};

// Ten seeds, one test: the sum of ten chi-squares of 3 degrees stays below the 99.9 % quantile
// of 30.
TEST_P(EitherParametrisation, EndsAtTheTruthWithinItsCovariance) {
  constexpr int kRuns = 10;
  double chi_square = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const RobotConfig robot = paperRobot(seed);
    Calibrator calibrator(configWith(GetParam()));
    const SimulatedRecord record = simulate(robot, 100.0);
    const CalibrationResult started = play(record, &calibrator, {0.0}, 0.0, 30.0);
    const CalibrationResult result = play(record, &calibrator, {0.0}, 30.0);
    ASSERT_TRUE(result.base_from_sensor.has_value());
    EXPECT_EQ(result.bearings_used + result.bearings_gated, record.bearings.size())
        << "seed " << seed;
    // 0.1 % is expected of the gate, once the filter is settled
    EXPECT_LT(result.bearings_gated - started.bearings_gated, 10U) << "seed " << seed;
    chi_square += mountChiSquare(*result.base_from_sensor, robot.base_from_sensor);
    EXPECT_LT(std::sqrt(result.base_from_sensor->covariance(0, 0)), 0.003);
  }
  EXPECT_LT(chi_square, chiSquareQuantile(0.999, 3.0 * kRuns));
}

INSTANTIATE_TEST_SUITE_P(Both, EitherParametrisation,
                         ::testing::Values(FilterConfig::Parametrisation::kCartesian,
                                           FilterConfig::Parametrisation::kPaper),
                         [](const auto& parametrisation) {
                           return parametrisation.param == FilterConfig::Parametrisation::kPaper
                                      ? "Paper"
                                      : "Cartesian";
                         });

TEST(Calibrator, LateImagesGiveTheSameAsPromptOnes) {
  const SimulatedRecord record = simulate(paperRobot(3), 60.0);
  Calibrator prompt(calibratorConfig());
  Calibrator late(calibratorConfig());
  const CalibrationResult a = play(record, &prompt);
  const CalibrationResult b = play(record, &late, {0.35});  // of arrival; the stamps are right
  ASSERT_TRUE(a.base_from_sensor && b.base_from_sensor);
  EXPECT_EQ(a.bearings_used, b.bearings_used);
  EXPECT_LT((a.base_from_sensor->mean - b.base_from_sensor->mean).norm(), 1e-9);
}

TEST(Calibrator, FusesTwoSensorsInTheOrderOfTheirStamps) {
  const SimulatedRecord record = simulate(paperRobot(3), 30.0);
  CalibratorConfig config = calibratorConfig();
  Calibrator in_order(config);
  Calibrator impatient(config);
  config.bearings.reorder_window_s = 0.15;
  Calibrator sorting(config);
  const std::vector<double> every_other_late = {0.0, 0.13};  // after the next one's arrival
  const auto expected = play(record, &in_order);
  const auto refused = play(record, &impatient, every_other_late);
  const auto sorted = play(record, &sorting, every_other_late);
  EXPECT_GT(refused.bearing_inputs[InputStatus::kStampNotAfterLast], 100U);
  EXPECT_EQ(sorted.bearing_inputs[InputStatus::kStampNotAfterLast], 0U);
  EXPECT_EQ(sorted.bearings_used + sorted.bearings_gated + sorted.bearings_waiting,
            expected.bearings_used + expected.bearings_gated);
}

TEST(Calibrator, LosesNoBearingAtTheEndOfARecord) {
  const SimulatedRecord record = simulate(paperRobot(3), 30.0);
  CalibratorConfig config = calibratorConfig();
  Calibrator prompt(config);
  config.bearings.reorder_window_s = 0.25;
  Calibrator waits(config);
  const CalibrationResult expected = play(record, &prompt);
  EXPECT_EQ(play(record, &waits).bearings_waiting, 3U);  // at 29.8, 29.9 and 30.0 s
  waits.finish();
  const CalibrationResult whole = waits.result();
  EXPECT_EQ(whole.bearings_waiting, 0U);
  EXPECT_EQ(whole.bearings_used + whole.bearings_gated,
            expected.bearings_used + expected.bearings_gated);
  EXPECT_EQ(whole.stamp, expected.stamp);
}

TEST(Calibrator, ALateStampIsTakenOffByTheLatency) {
  RobotConfig robot = paperRobot(8);
  robot.stamp_latency_s = 0.1;
  CalibratorConfig config = calibratorConfig();
  Calibrator unaware(config);
  config.bearings.latency_s = 0.1;
  Calibrator aware(config);
  const SimulatedRecord record = simulate(robot, 100.0);
  const CalibrationResult right = play(record, &aware);
  EXPECT_EQ(right.state, CalibrationState::kConverged);
  EXPECT_LT(mountChiSquare(*right.base_from_sensor, robot.base_from_sensor),
            chiSquareQuantile(0.999, 3.0));
  // at 1.6 rad/s 0.1 s are 9 degrees, nine standard deviations: it does not fit, and that is seen
  const CalibrationResult wrong = play(record, &unaware);
  EXPECT_NE(wrong.state, CalibrationState::kConverged);
  constexpr std::uint32_t kMostOfASoundRobot = 5;  // of 1000 at 99.9 %, in 999 of 1000 runs
  EXPECT_GT(wrong.bearings_gated, kMostOfASoundRobot);
}

// The same drive and noise, with spins at 1 rad/s: the offset, once set, costs the bearings of its
// own length at the end and nothing else.
TEST(Calibrator, AKnownLateStampCostsNothing) {
  constexpr double kLatency_s = 0.1;
  constexpr double kSpin_radps = 1.0;
  RobotConfig robot = paperRobot(9);
  const double separation_m = robot.encoders.drive.wheel_separation_m;
  TrajectoryConfig dance;
  dance.wheel_speed_mps = 0.5 * separation_m * kSpin_radps;
  CalibratorConfig config = calibratorConfig();
  std::vector<MountEstimate> mounts;
  for (double latency_s : {0.0, kLatency_s}) {
    robot.stamp_latency_s = latency_s;
    config.bearings.latency_s = latency_s;
    RobotSimulator simulator(robot, {Light{}}, makeTrajectory(dance, separation_m));
    Calibrator calibrator(config);
    const CalibrationResult result = play(record(&simulator, 100.0), &calibrator);
    EXPECT_EQ(result.state, CalibrationState::kConverged);
    ASSERT_TRUE(result.base_from_sensor);
    mounts.push_back(*result.base_from_sensor);
  }
  const Pose2 in_time{mounts[0].mean.head<2>(), mounts[0].mean.z()};
  EXPECT_LT(mountChiSquare(mounts[1], in_time), 0.01);  // a tenth of a standard deviation
  // One second of a hundred less information.
  EXPECT_LT(mounts[1].covariance.trace(), 1.01 * mounts[0].covariance.trace());
}

/// As the sensors would have stamped it, had their clock stepped back after so long.
SimulatedRecord steppedBack(SimulatedRecord record, double after_s, double step_s) {
  const Stamp moment = record.ticks.front().stamp + durationFromSeconds(after_s);
  const auto follow = [&](auto* stamped) {
    if (stamped->stamp > moment) stamped->stamp -= durationFromSeconds(step_s);
  };
  for (WheelCounts& ticks : record.ticks) follow(&ticks);
  for (BearingSet& bearings : record.bearings) follow(&bearings);
  return record;
}

/// Ticks and bearings in the order in which they were measured, whatever they are stamped.
CalibrationResult playInOrderOf(const SimulatedRecord& measured, const SimulatedRecord& stamped,
                                Calibrator* calibrator) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < measured.ticks.size(); ++i) {
    for (; next < measured.bearings.size() &&
           measured.bearings[next].stamp <= measured.ticks[i].stamp;
         ++next) {
      calibrator->addBearings(stamped.bearings[next], stamped.bearings[next].stamp);
    }
    calibrator->addTicks(stamped.ticks[i], stamped.ticks[i].stamp);
  }
  return calibrator->result();
}

// Network time steps back by 0.25 or 0.9 s in the middle of a spin at 1.6 rad/s.
// Promise unharmed: a clock that steps back during a drive
TEST(Calibrator, LivesThroughAStepBackOfTheClock) {
  constexpr double kStepped_s = 108.0;
  const RobotConfig robot = paperRobot(4);
  const SimulatedRecord measured = simulate(robot, 160.0);
  const CalibrationResult undisturbed = [&] {
    Calibrator calibrator(calibratorConfig());
    return play(measured, &calibrator);
  }();
  ASSERT_EQ(undisturbed.state, CalibrationState::kConverged);
  for (const double step_s : {0.25, 0.9}) {
    Calibrator calibrator(calibratorConfig());
    const CalibrationResult result =
        playInOrderOf(measured, steppedBack(measured, kStepped_s, step_s), &calibrator);
    EXPECT_EQ(result.state, CalibrationState::kConverged) << result.advice;
    EXPECT_EQ(result.tick_inputs.badInputs(), std::lround(100.0 * step_s)) << "what overlaps";
    EXPECT_EQ(result.tick_inputs[InputStatus::kStampNotAfterLast], std::lround(100.0 * step_s));
    EXPECT_EQ(result.bearing_inputs.badInputs(),
              result.bearing_inputs[InputStatus::kStampNotAfterLast]);
    EXPECT_LE(result.bearing_inputs.badInputs(), std::lround(10.0 * step_s) + 1);
    EXPECT_LE(result.bearings_gated, undisturbed.bearings_gated + 1U) << "no motion is lost";
    EXPECT_LT(mountChiSquare(*result.base_from_sensor, robot.base_from_sensor),
              chiSquareQuantile(0.999, 3.0));
  }
}

TEST(Calibrator, PredictsTheNextBearing) {
  const RobotConfig robot = paperRobot(2);
  SimulatedRecord record = simulate(robot, 60.0);
  const BearingSet last = record.bearings.back();
  while (record.bearings.back().stamp > last.stamp - std::chrono::seconds(1)) {
    record.bearings.pop_back();
  }
  Calibrator calibrator(calibratorConfig());
  EXPECT_FALSE(calibrator.predictBearing(robot.start).has_value());
  play(record, &calibrator);
  const auto prediction = calibrator.predictBearing(last.stamp);
  ASSERT_TRUE(prediction.has_value());
  EXPECT_NEAR(
      wrapAngle(prediction->azimuth_rad - last.candidates[0].azimuth_rad), 0.0,
      4.0 * std::hypot(robot.sensor.stddev_rad, std::sqrt(prediction->azimuth_variance_rad2)));
  const Pose2 world_from_sensor = record.world_from_base.back() * robot.base_from_sensor;
  const double distance_m = world_from_sensor.position_m.norm();  // the light is at the origin
  const double stddev_m = std::sqrt(prediction->distance_variance_m2);
  EXPECT_LT(stddev_m, 0.05 * distance_m);
  EXPECT_NEAR(prediction->distance_m, distance_m, 3.0 * stddev_m);
}

// ---- a small robot ----

/// 88 mm between its wheels. It drives 9 m and turns 390 rad, and all within 18 cm.
RobotConfig smallRobot(std::uint64_t seed) {
  RobotConfig robot = paperRobot(seed);
  robot.encoders.drive.wheel_separation_m = 0.088;
  robot.encoders.drive.left_wheel_radius_m = 0.016;
  robot.encoders.drive.right_wheel_radius_m = 0.016;
  robot.base_from_sensor = {{0.02, 0.01}, 0.5};
  robot.world_from_start = {{1.3, 0.0}, 1.0};
  return robot;
}

SimulatedRecord smallDrive(const RobotConfig& robot, double duration_s) {
  constexpr double kSpeed_mps = 0.1;
  constexpr double kLeg_m = 0.1;
  constexpr double kTurn_rad = 4.31;
  const double arc_m = 0.5 * robot.encoders.drive.wheel_separation_m * kTurn_rad;
  RobotSimulator simulator(robot, {Light{}},
                           segmentTrajectory({{kSpeed_mps, kSpeed_mps, kLeg_m / kSpeed_mps},
                                              {-kSpeed_mps, kSpeed_mps, arc_m / kSpeed_mps}}));
  return record(&simulator, duration_s);
}

// The Cramer-Rao bound of such a record is 0.9 mm and 1.1 degrees, whatever its extent.
TEST(ASmallRobot, IsCalibratedWithinItsOwnLength) {
  constexpr int kRuns = 3;
  double chi_square = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const RobotConfig robot = smallRobot(seed);
    Calibrator calibrator(defaultCalibration(robot.encoders.drive, robot.encoders.noise));
    const CalibrationResult result = play(smallDrive(robot, 260.0), &calibrator);
    EXPECT_TRUE(result.state == CalibrationState::kConverging ||
                result.state == CalibrationState::kConverged)
        << nameOf(result.state) << ": " << result.advice;
    ASSERT_TRUE(result.base_from_sensor.has_value());
    chi_square += mountChiSquare(*result.base_from_sensor, robot.base_from_sensor);
    const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
    EXPECT_LT(stddev.head<2>().maxCoeff(), 0.002);
    EXPECT_LT(stddev.z(), radiansFromDegrees(2.0));
  }
  EXPECT_LT(chi_square, chiSquareQuantile(0.999, 3.0 * kRuns));
}

// ---- a turn that nobody has counted ----

Bearing bearingOf(double azimuth_rad) {
  return bearingsAt(Stamp(), azimuth_rad).candidates.front();
}

/// A tracker that knows its mount to a centimetre and half a degree, with the light 2 m ahead,
/// after a turn of which nothing is known.
MountTracker afterAnUnknownTurn() {
  CartesianEstimate start;
  start.mean << 2.0, 0.0, 0.1, 0.0, 0.0;
  start.covariance.diagonal() << 1e-4, 1e-4, 1e-4, 1e-4, 1e-4;
  MountTracker tracker(calibratorConfig().filter, StateEstimate::of(start), 0.0);
  OdometryIncrement unknown;
  unknown.covariance.diagonal() << 0.01, 0.01, 10.0;
  tracker.move(unknown);
  return tracker;
}

void expectTheMountAsBefore(const MountTracker& tracker) {
  const CartesianEstimate estimate = tracker.filter().estimate().cartesian();
  constexpr double kRounding = 1e-12;
  EXPECT_LT((estimate.sensorInBase() - Eigen::Vector2d(0.1, 0.0)).norm(), kRounding);
  EXPECT_NEAR(estimate.sensorYaw(), 0.0, kRounding);
  const Eigen::Vector3d variances = estimate.covariance.diagonal().tail<3>();
  EXPECT_LT((variances - Eigen::Vector3d::Constant(1e-4)).norm(), kRounding);
}

// One of the two stands about where the filter would expect the light, had it not turned.
// Promise honest: several candidates after an unknown turn
TEST(AnUnknownTurn, OfSeveralCandidatesNoneIsTaken) {
  MountTracker tracker = afterAnUnknownTurn();
  const std::vector<Bearing> both = {bearingOf(0.02), bearingOf(1.5)};
  constexpr int kImages = 30;
  for (int i = 0; i < kImages; ++i) {
    EXPECT_NE(tracker.fuse(both, {}, false).kind, Association::Kind::kFound);
    EXPECT_TRUE(tracker.isSearching());
  }
  expectTheMountAsBefore(tracker);
  tracker.fuse({bearingOf(1.5)}, {}, false);
  EXPECT_FALSE(tracker.isSearching());
  expectTheMountAsBefore(tracker);
  const Eigen::Vector2d light = tracker.filter().estimate().cartesian().lightInBase();
  EXPECT_NEAR(std::atan2(light.y(), light.x() - 0.1), 1.5, 1e-9);
}

TEST(AnUnknownTurn, TheOnlyCandidateIsNotTakenWhereItMayBeAnotherLight) {
  MountTracker tracker = afterAnUnknownTurn();
  EXPECT_NE(tracker.fuse({bearingOf(1.5)}, {}, true).kind, Association::Kind::kFound);
  EXPECT_TRUE(tracker.isSearching());
  expectTheMountAsBefore(tracker);
}

TEST(AnUnknownTurn, WithSeveralCandidatesForEverIsLostInTheEnd) {
  MountTracker tracker = afterAnUnknownTurn();
  const std::vector<Bearing> both = {bearingOf(0.02), bearingOf(1.5)};
  for (int i = 0; i < RecentInnovations::kWindow; ++i) {
    tracker.fuse(both, {}, false);
    if (tracker.isLost()) break;
  }
  EXPECT_TRUE(tracker.isLost());
  EXPECT_FALSE(tracker.isSearching());
}

// ---- going on from an earlier calibration ----

MountEstimate earlierMount(const Pose2& mount) {
  MountEstimate earlier;
  earlier.mean << mount.position_m, mount.yaw_rad;
  earlier.covariance.diagonal() << 9e-6, 9e-6, 3e-5;  // 3 mm, 0.3 deg
  return earlier;
}

// Two independent estimates together: the information of both adds up.
TEST(TakenUp, AddsItsInformation) {
  const RobotConfig robot = paperRobot(4);
  const SimulatedRecord record = simulate(robot, 60.0);
  Calibrator alone(calibratorConfig());
  Calibrator with_earlier(calibratorConfig());
  const MountEstimate earlier = earlierMount(robot.base_from_sensor);
  with_earlier.resume(lastingPart(earlier));
  const MountEstimate by_itself = *play(record, &alone).base_from_sensor;
  const MountEstimate together = *play(record, &with_earlier).base_from_sensor;
  const Eigen::Matrix3d information = by_itself.covariance.inverse() + earlier.covariance.inverse();
  EXPECT_LT((together.covariance * information - Eigen::Matrix3d::Identity()).norm(), 0.05);
  EXPECT_LT(mountChiSquare(together, robot.base_from_sensor), chiSquareQuantile(0.999, 3.0));
}

TEST(TakenUp, IsThereFromTheFirstBearingsOn) {
  const RobotConfig robot = paperRobot(4);
  Calibrator calibrator(calibratorConfig());
  calibrator.resume(lastingPart(earlierMount(robot.base_from_sensor)));
  const CalibrationResult result = play(simulate(robot, 1.0), &calibrator);
  ASSERT_TRUE(result.base_from_sensor.has_value());
  EXPECT_LT(std::sqrt(result.base_from_sensor->covariance(0, 0)), 0.0031);
}

// Bearings tell what the wheels' scales and their separation have in common as little as all other
// lengths, however often a robot starts: what is known of them beforehand, in three numbers of
// which the data tell two differences, is counted once, not at each start.
TEST(TakenUp, CountsWhatIsKnownBeforehandOnce) {
  constexpr double kScaleStddev = 0.03;
  constexpr double kSeparationPrior = 0.01;
  const double separation_expected =
      1.0 / std::sqrt(1.0 / std::pow(kSeparationPrior, 2) + 2.0 / std::pow(kScaleStddev, 2));
  CalibratorConfig config = calibratorConfig();
  config.initializer.batch.errors.setBlock(WheelScales::kName, kScaleStddev);
  config.initializer.batch.errors.setBlock(WheelSeparation::kName, kSeparationPrior);
  std::optional<StateEstimate> earlier;
  constexpr int kStarts = 6;
  for (int start = 1; start <= kStarts; ++start) {
    const RobotConfig robot = paperRobot(static_cast<std::uint64_t>(start));
    Calibrator calibrator(config);
    if (earlier) calibrator.resume(*earlier);
    const CalibrationResult result = play(simulate(robot, 60.0), &calibrator);
    ASSERT_TRUE(result.base_from_sensor.has_value());
    const double separation_stddev = std::sqrt(
        result.robot_errors.covariance(placeOf<WheelSeparation>(), placeOf<WheelSeparation>()));
    EXPECT_NEAR(separation_stddev, separation_expected, 0.02 * separation_expected);
    // The mount's distance from the base is measured by it.
    const Eigen::Vector2d way = robot.base_from_sensor.position_m;
    const double along_m = std::sqrt(way.normalized().dot(
        result.base_from_sensor->covariance.topLeftCorner<2, 2>() * way.normalized()));
    EXPECT_GT(along_m, 0.98 * separation_expected * way.norm()) << "start " << start;
    earlier = lastingPart(*result.estimate);
  }
}

// Promise honest: a resumed result that the observations contradict
TEST(TakenUp, IsForgottenWhenTheObservationsContradictIt) {
  const RobotConfig robot = paperRobot(4);
  Pose2 elsewhere = robot.base_from_sensor;
  elsewhere.position_m.x() += 0.1;
  elsewhere.yaw_rad += radiansFromDegrees(20.0);
  Calibrator calibrator(calibratorConfig());
  calibrator.resume(lastingPart(earlierMount(elsewhere)));
  const CalibrationResult result = play(simulate(robot, 60.0), &calibrator);
  ASSERT_TRUE(result.base_from_sensor.has_value());
  EXPECT_LT(mountChiSquare(*result.base_from_sensor, robot.base_from_sensor),
            chiSquareQuantile(0.999, 3.0));
}

// ---- a sensor that says how well it knows its own geometry ----

/// A robot under a mirror that leans by 1 deg, and what it records.
struct UnderAMisalignedMirror {
  static constexpr SensorGeometry kUnmeasured{0.03, 0.0, 0.004};

  explicit UnderAMisalignedMirror(const SensorGeometry& stated) {
    robot.sensor.harmonic_cos_rad = 0.025;
    robot.sensor.harmonic_sin_rad = -0.01;
    record = simulate(robot, 100.0);
    for (BearingSet& image : record.bearings) image.geometry = stated;
  }

  RobotConfig robot = paperRobot(2);
  SimulatedRecord record;
};

TEST(SensorGeometry, IsLookedForAsFarAsTheSensorSays) {
  const UnderAMisalignedMirror unmeasured(UnderAMisalignedMirror::kUnmeasured);
  Calibrator calibrator(calibratorConfig());
  const CalibrationResult result = play(unmeasured.record, &calibrator);
  ASSERT_TRUE(result.base_from_sensor.has_value());
  EXPECT_LT(mountChiSquare(*result.base_from_sensor, unmeasured.robot.base_from_sensor),
            chiSquareQuantile(0.999, 3.0));
  constexpr int kHarmonic = placeOf<MirrorHarmonic>();
  const Eigen::Vector2d found = result.robot_errors.mean.segment<2>(kHarmonic);
  const Eigen::Matrix2d covariance =
      result.robot_errors.covariance.block<2, 2>(kHarmonic, kHarmonic);
  const Eigen::Vector2d off = found - Eigen::Vector2d(0.025, -0.01);
  EXPECT_LT(off.dot(covariance.inverse() * off), chiSquareQuantile(0.999, 2.0)) << found;
  EXPECT_LT(std::sqrt(covariance(0, 0)),
            0.5 * UnderAMisalignedMirror::kUnmeasured.harmonic_stddev_rad);
  EXPECT_EQ(result.bearing_inputs[InputStatus::kGeometryChanged], 0U) << "known from the first on";

  const UnderAMisalignedMirror unsaid{{}};
  Calibrator trusting(calibratorConfig());
  const CalibrationResult wrong = play(unsaid.record, &trusting);
  ASSERT_TRUE(wrong.base_from_sensor.has_value());
  EXPECT_GT(mountChiSquare(*wrong.base_from_sensor, unsaid.robot.base_from_sensor), 100.0);
}

// Exactly what no bearing tells is in what is said, and in nothing else.
TEST(SensorGeometry, NearnessIsInThePositionsVariance) {
  SensorGeometry apex_in_place = UnderAMisalignedMirror::kUnmeasured;
  apex_in_place.nearness_stddev_rad_m = 0.0;
  Calibrator known(calibratorConfig());
  Calibrator unknown(calibratorConfig());
  const MountEstimate a =
      *play(UnderAMisalignedMirror(apex_in_place).record, &known).base_from_sensor;
  const MountEstimate b =
      *play(UnderAMisalignedMirror(UnderAMisalignedMirror::kUnmeasured).record, &unknown)
           .base_from_sensor;
  EXPECT_EQ((a.mean - b.mean).norm(), 0.0);
  Eigen::Matrix3d expected = a.covariance;
  expected.diagonal().head<2>().array() +=
      std::pow(UnderAMisalignedMirror::kUnmeasured.nearness_stddev_rad_m, 2);
  EXPECT_LT((b.covariance - expected).norm(), 1e-12);
}

TEST(SensorGeometry, KnownLessWellThanBeforeBeginsTheCalibrationAgain) {
  UnderAMisalignedMirror later(UnderAMisalignedMirror::kUnmeasured);
  for (std::size_t i = 0; i < later.record.bearings.size() / 2; ++i) {
    later.record.bearings[i].geometry = {};
  }
  Calibrator calibrator(calibratorConfig());
  const CalibrationResult result = play(later.record, &calibrator);
  EXPECT_EQ(result.bearing_inputs[InputStatus::kGeometryChanged], 1U);
  EXPECT_LE(result.bearings_used, later.record.bearings.size() / 2 + 1);
  ASSERT_TRUE(result.base_from_sensor.has_value());
  EXPECT_LT(mountChiSquare(*result.base_from_sensor, later.robot.base_from_sensor),
            chiSquareQuantile(0.999, 3.0));
}

// Where the mirror's centre was measured anew, its bearings obey another law.
TEST(SensorGeometry, AnotherLawForNearLightsBeginsTheCalibrationAgain) {
  const SensorGeometry measured{0.02, -0.6, 0.005};
  SensorGeometry nearly = measured;
  nearly.near_per_far_m = -0.5;
  for (const auto& [later, times] :
       {std::pair(SensorGeometry{0.02, 0.0, 0.005}, 1U), std::pair(nearly, 0U)}) {
    Calibrator calibrator(calibratorConfig());
    UnderAMisalignedMirror changing(measured);
    for (std::size_t i = changing.record.bearings.size() / 2; i < changing.record.bearings.size();
         ++i) {
      changing.record.bearings[i].geometry = later;
    }
    const CalibrationResult result = play(changing.record, &calibrator);
    EXPECT_EQ(result.bearing_inputs[InputStatus::kGeometryChanged], times);
  }
}

// A sensor may have been aligned before the owner calls ~reset.
TEST(SensorGeometry, IsForgottenByAReset) {
  Calibrator calibrator(calibratorConfig());
  play(UnderAMisalignedMirror(UnderAMisalignedMirror::kUnmeasured).record, &calibrator);
  calibrator.reset();
  const UnderAMisalignedMirror aligned{{}};
  const CalibrationResult result = play(aligned.record, &calibrator);
  ASSERT_TRUE(result.base_from_sensor.has_value());
  EXPECT_EQ(result.robot_errors.covariance(placeOf<MirrorHarmonic>(), placeOf<MirrorHarmonic>()),
            0.0);
}

// The paper's state has no place for it: taken for noise, it would make a wrong mount look sure.
TEST(SensorGeometry, IsRefusedByThePapersFilter) {
  Calibrator calibrator(configWith(FilterConfig::Parametrisation::kPaper));
  BearingSet bearings = bearingsAt(stampFromSeconds(1.0), 0.0);
  bearings.geometry = UnderAMisalignedMirror::kUnmeasured;
  const InputOutcome outcome = calibrator.addBearings(bearings, bearings.stamp);
  EXPECT_EQ(outcome.status, InputStatus::kGeometryUnmodelled);
  EXPECT_NE(describe(outcome).find("alignment/harmonic_stddev"), std::string::npos);
}

// ---- bad input: refused, counted, and without any other effect ----

class BadInput : public ::testing::Test {
 protected:
  BadInput() : calibrator_(calibratorConfig()) {
    record_ = simulate(paperRobot(1), 10.0);
    before_ = play(record_, &calibrator_);
    last_ = record_.ticks.back().stamp;
  }

  void expectNothingChanged() {
    const CalibrationResult after = calibrator_.result();
    EXPECT_EQ(after.bearings_used, before_.bearings_used);
    EXPECT_EQ(after.ticks_used, before_.ticks_used);
    EXPECT_EQ((after.base_from_sensor->mean - before_.base_from_sensor->mean).norm(), 0.0);
    EXPECT_EQ((after.base_from_sensor->covariance - before_.base_from_sensor->covariance).norm(),
              0.0);
  }

  void expectRefused(const BearingSet& bearings, InputStatus status) {
    const InputOutcome outcome = calibrator_.addBearings(bearings, last_);
    EXPECT_STREQ(nameOf(outcome.status), nameOf(status)) << describe(outcome);
    EXPECT_EQ(calibrator_.result().bearing_inputs[status], 1U);
    expectNothingChanged();
  }

  Calibrator calibrator_;
  SimulatedRecord record_;
  CalibrationResult before_;
  Stamp last_;
};

TEST_F(BadInput, AzimuthNotFinite) {
  expectRefused(bearingsAt(last_ + Duration(1), kNaN), InputStatus::kAzimuthNotFinite);
}
TEST_F(BadInput, AzimuthInfinite) {
  expectRefused(bearingsAt(last_ + Duration(1), INFINITY), InputStatus::kAzimuthNotFinite);
}
TEST_F(BadInput, AzimuthBeyondATurn) {
  expectRefused(bearingsAt(last_ + Duration(1), -6.3), InputStatus::kAzimuthBeyondATurn);
  const auto turn = static_cast<double>(static_cast<float>(2.0 * kPi));  // of a driver with floats
  EXPECT_TRUE(calibrator_.addBearings(bearingsAt(last_ + Duration(2), turn), last_).accepted());
}
TEST_F(BadInput, VarianceZeroNegativeAbsurd) {
  BearingSet bearings = bearingsAt(last_ + Duration(1), 0.0);
  bearings.candidates[0].azimuth_variance_rad2 = 100.0;
  expectRefused(bearings, InputStatus::kVarianceAbsurd);
  bearings.stamp += Duration(1);
  bearings.candidates[0].azimuth_variance_rad2 = 0.0;
  expectRefused(bearings, InputStatus::kVarianceNotPositive);
  bearings.stamp += Duration(1);
  bearings.candidates[0].azimuth_variance_rad2 = -1.0;
  EXPECT_EQ(calibrator_.addBearings(bearings, last_).status, InputStatus::kVarianceNotPositive);
}
TEST_F(BadInput, QualityOutOfRange) {
  BearingSet bearings = bearingsAt(last_ + Duration(1), 0.0);
  bearings.candidates[0].probability = 1.5;
  expectRefused(bearings, InputStatus::kProbabilityOutOfRange);
}
TEST_F(BadInput, TrackProbabilityOutOfRange) {
  BearingSet bearings = bearingsAt(last_ + Duration(1), 0.0);
  bearings.candidates[0].track_probability = -0.5;
  expectRefused(bearings, InputStatus::kProbabilityOutOfRange);
}
// Zero is a message's default; a light that is hardly one is no mistake of the sensor.
TEST(CheckedBearings, SayThatAProbabilityIsNotFilledIn) {
  BearingInputConfig config;
  config.max_stddev_rad = 1.0;
  config.min_probability = 0.1;
  BearingSet set = bearingsAt(Stamp(Duration(1)), 0.0);
  for (const auto& [probability, remarks] : {std::pair(0.0, 1U), std::pair(0.05, 0U)}) {
    set.candidates[0].probability = probability;
    const CheckedBearings checked = checkBearings(set, config);
    EXPECT_TRUE(checked.bearings.candidates.empty());
    ASSERT_EQ(checked.remarks.size(), remarks);
    for (const InputOutcome& remark : checked.remarks) {
      EXPECT_EQ(remark.status, InputStatus::kProbabilityZero);
    }
  }
}
TEST(CheckedBearings, AreThoseOfAProbableTrackOrElseImage) {
  BearingInputConfig config;
  config.max_stddev_rad = 1.0;
  config.min_probability = 0.3;
  BearingSet set = {Stamp(Duration(1)), std::vector<Bearing>(4)};
  const double image[] = {0.2, 0.9, 0.9, 0.2};
  const double track[] = {0.9, 0.2, 0.0, kNaN};
  for (std::size_t i = 0; i < set.candidates.size(); ++i) {
    Bearing& candidate = set.candidates[i];
    candidate.azimuth_rad = static_cast<double>(i);
    candidate.azimuth_variance_rad2 = 1e-4;
    candidate.probability = image[i];
    candidate.track_probability = track[i];
  }
  const CheckedBearings checked = checkBearings(set, config);
  ASSERT_EQ(checked.bearings.candidates.size(), 2U);
  EXPECT_EQ(checked.bearings.candidates[0].azimuth_rad, 0.0);
  EXPECT_EQ(checked.bearings.candidates[1].azimuth_rad, 2.0);
  EXPECT_TRUE(checked.remarks.empty());
}
TEST_F(BadInput, GeometryThatNoMirrorHas) {
  BearingSet bearings = bearingsAt(last_ + Duration(1), 0.0);
  bearings.geometry.harmonic_stddev_rad = -0.01;
  expectRefused(bearings, InputStatus::kGeometryAbsurd);
  bearings.geometry = {0.01, 0.0, 5.0};
  EXPECT_EQ(calibrator_.addBearings(bearings, last_).status, InputStatus::kGeometryAbsurd);
  bearings.geometry = {0.01, INFINITY, 0.0};
  EXPECT_EQ(calibrator_.addBearings(bearings, last_).status, InputStatus::kGeometryAbsurd);
  expectNothingChanged();
}
// Promise refused: a field of view in degrees
TEST_F(BadInput, FieldOfViewThatIsNoPartOfATurn) {
  BearingSet bearings = bearingsAt(last_ + Duration(1), 0.0);
  bearings.view = {0.0, 60.0};  // in degrees
  expectRefused(bearings, InputStatus::kViewImpossible);
  const InputOutcome outcome = calibrator_.addBearings(bearings, last_);
  EXPECT_NE(describe(outcome).find("(view_centre, view_width) of 60 rad"), std::string::npos);
  bearings.view = {kNaN, 1.0};
  EXPECT_EQ(calibrator_.addBearings(bearings, last_).status, InputStatus::kViewImpossible);
  expectNothingChanged();
}
TEST_F(BadInput, StampZero) { expectRefused(bearingsAt(Stamp(), 0.0), InputStatus::kNoStamp); }
TEST_F(BadInput, StampInTheFuture) {
  expectRefused(bearingsAt(last_ + durationFromSeconds(60.0), 0.0), InputStatus::kStampInFuture);
}
TEST_F(BadInput, StampBeforeTheLast) {
  expectRefused(bearingsAt(record_.bearings[5].stamp, 0.0), InputStatus::kStampNotAfterLast);
}

TEST_F(BadInput, AGoodCandidateBesideABadOneIsUsed) {
  const Stamp soon = last_ + durationFromSeconds(0.01);
  const double azimuth = calibrator_.predictBearing(last_)->azimuth_rad;
  BearingSet bearings = bearingsAt(last_ + durationFromSeconds(0.005), kNaN);
  bearings.candidates.push_back(bearingsAt(bearings.stamp, azimuth).candidates[0]);
  calibrator_.addBearings(bearings, soon);
  const WheelCounts& end = record_.ticks.back();
  calibrator_.addTicks({soon, end.left_ticks, end.right_ticks}, soon);
  const CalibrationResult after = calibrator_.result();
  EXPECT_EQ(after.bearings_used + after.bearings_gated,
            before_.bearings_used + before_.bearings_gated + before_.bearings_waiting + 1U);
  EXPECT_EQ(after.bearing_inputs[InputStatus::kAzimuthNotFinite], 1U);
}

TEST_F(BadInput, TicksThatJump) {
  const WheelCounts jump{last_ + durationFromSeconds(0.01), 1000000000, 1000000000};
  EXPECT_EQ(calibrator_.addTicks(jump, last_).status, InputStatus::kTicksTooFast);
  expectNothingChanged();
}

// ---- sensors that are wrong about themselves ----

/// A record of which every n-th image is spoilt.
SimulatedRecord spoilt(SimulatedRecord record, std::size_t n, void (*spoil)(Bearing*)) {
  for (std::size_t i = 0; i < record.bearings.size(); i += n) {
    for (Bearing& candidate : record.bearings[i].candidates) spoil(&candidate);
  }
  return record;
}

bool speaksOf(const CalibrationResult& result, const std::string& words) {
  return result.advice.find(words) != std::string::npos;
}

TEST(ASensorInDegrees, IsNamedBeforeAnythingElse) {
  const SimulatedRecord record = spoilt(simulate(paperRobot(1), 30.0), 1, [](Bearing* bearing) {
    bearing->azimuth_rad = degreesFromRadians(bearing->azimuth_rad);
  });
  Calibrator calibrator(calibratorConfig());
  for (const auto& [from_s, to_s] : {std::pair(0.0, 1.0), std::pair(1.0, 30.0)}) {
    const CalibrationResult result = play(record, &calibrator, {0.0}, from_s, to_s);
    EXPECT_TRUE(speaksOf(result, "is the sensor in degrees? bearings are in radians"))
        << result.advice;
    EXPECT_FALSE(speaksOf(result, "swapped")) << result.advice;
  }
}

// The light hardly leaves the line ahead: four of five values look like radians.
TEST(ASensorInDegrees, IsNamedWhereFewOfItsValuesTell) {
  SimulatedRecord record = simulate(paperRobot(1), 10.0);
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    for (Bearing& bearing : record.bearings[i].candidates) {
      bearing.azimuth_rad = i % 5 == 0 ? 7.0 : 3.0;
    }
  }
  Calibrator calibrator(calibratorConfig());
  EXPECT_TRUE(speaksOf(play(record, &calibrator), "is the sensor in degrees?"));
}

TEST(ASensorInDegrees, IsNotSuspectedForAGlitch) {
  const SimulatedRecord record = spoilt(simulate(paperRobot(1), 60.0), 400,
                                        [](Bearing* bearing) { bearing->azimuth_rad = 100.0; });
  Calibrator calibrator(calibratorConfig());
  EXPECT_FALSE(speaksOf(play(record, &calibrator), "degrees?"));
}

// One bearing in ten states what no sensor knows: it counts as the best that a sensor may be.
TEST(AVarianceThatNoSensorHas, IsRaisedCountedAndSaid) {
  constexpr std::size_t kOneIn = 10;
  const SimulatedRecord record = simulate(paperRobot(1), 60.0);
  Calibrator stated(calibratorConfig());
  Calibrator raised(calibratorConfig());
  const CalibrationResult a =
      play(spoilt(record, kOneIn, [](Bearing* bearing) { bearing->azimuth_variance_rad2 = 1e-12; }),
           &stated);
  const CalibrationResult b =
      play(spoilt(record, kOneIn,
                  [](Bearing* bearing) { bearing->azimuth_variance_rad2 = 1e-4 * 1e-4; }),
           &raised);
  ASSERT_TRUE(a.base_from_sensor && b.base_from_sensor);
  EXPECT_EQ((a.base_from_sensor->mean - b.base_from_sensor->mean).norm(), 0.0);
  EXPECT_EQ((a.base_from_sensor->covariance - b.base_from_sensor->covariance).norm(), 0.0);
  EXPECT_EQ(a.bearings_used, b.bearings_used);
  EXPECT_TRUE(speaksOf(a, "bearings/min_stddev")) << a.advice;
  EXPECT_FALSE(speaksOf(b, "bearings/min_stddev")) << b.advice;
  EXPECT_EQ(a.bearing_inputs[InputStatus::kVarianceRaised], (record.bearings.size() + 9) / kOneIn);
  EXPECT_EQ(a.bearing_inputs[InputStatus::kAccepted], record.bearings.size());
  EXPECT_EQ(a.bearing_inputs.badInputs(), 0U);
}

TEST(AVarianceThatNoSensorHas, IsRaisedForElevationsToo) {
  Calibrator calibrator(calibratorConfig());
  std::vector<double> seen;
  calibrator.observe([&](const AssociationOutcome& outcome) {
    seen.push_back(outcome.observation.elevation->variance_rad2);
  });
  play(spoilt(simulate(paperRobot(1), 1.0), 1,
              [](Bearing* bearing) {
                bearing->elevation_rad = 0.1;
                bearing->elevation_variance_rad2 = 1e-12;
              }),
       &calibrator);
  ASSERT_FALSE(seen.empty());
  for (double variance : seen) EXPECT_DOUBLE_EQ(variance, 1e-8);
}

// Promise bounded: bearings without wheel readings, in the core
TEST(Calibrator, BearingsWithoutTicksAreBounded) {
  CalibratorConfig config = calibratorConfig();
  config.bearings.max_waiting = 50;
  Calibrator calibrator(config);
  for (int i = 1; i <= 1000; ++i) {
    const Stamp stamp = stampFromSeconds(10.0 + 0.1 * i);
    calibrator.addBearings(bearingsAt(stamp, 0.0), stamp);
  }
  const CalibrationResult result = calibrator.result();
  EXPECT_EQ(result.state, CalibrationState::kWaitingForTicks);
  EXPECT_EQ(result.bearings_waiting, 50U);
  EXPECT_EQ(result.bearing_inputs[InputStatus::kQueueFull], 950U);
}

TEST(Calibrator, TicksWithoutBearingsWaitForTheLight) {
  Calibrator calibrator(calibratorConfig());
  SimulatedRecord record = simulate(paperRobot(1), 10.0);
  record.bearings.clear();
  const CalibrationResult result = play(record, &calibrator);
  EXPECT_EQ(result.state, CalibrationState::kWaitingForLight);
  // 1 m and the start of the second one; the wheels' noise in the spin adds a little
  EXPECT_NEAR(result.distance_travelled_m, 1.018, 0.03);
}

TEST(Calibrator, PausedIgnoresBearingsAndFollowsTicks) {
  Calibrator calibrator(calibratorConfig());
  const SimulatedRecord record = simulate(paperRobot(1), 20.0);
  play(record, &calibrator, {0.0}, 0.0, 10.0);
  calibrator.setPaused(true);
  const CalibrationResult paused = play(record, &calibrator, {0.0}, 10.0, 15.0);
  EXPECT_EQ(paused.state, CalibrationState::kPaused);
  EXPECT_GT(paused.bearing_inputs[InputStatus::kIgnoredPaused], 40U);
  calibrator.setPaused(false);
  const CalibrationResult resumed = play(record, &calibrator, {0.0}, 15.0, 20.1);
  EXPECT_GT(resumed.bearings_used, paused.bearings_used + 40U);  // the motion was not lost
}

TEST(Calibrator, ResetForgetsEverything) {
  Calibrator calibrator(calibratorConfig());
  play(simulate(paperRobot(1), 10.0), &calibrator);
  calibrator.reset();
  const CalibrationResult result = calibrator.result();
  EXPECT_EQ(result.state, CalibrationState::kWaitingForTicks);
  EXPECT_EQ(result.ticks_used, 0U);
  EXPECT_FALSE(result.base_from_sensor.has_value());
}

TEST(Calibrator, ResetDoesNotEndAPause) {
  Calibrator calibrator(calibratorConfig());
  const SimulatedRecord record = simulate(paperRobot(1), 10.0);
  play(record, &calibrator);
  calibrator.setPaused(true);
  calibrator.reset();
  const CalibrationResult result = play(record, &calibrator);
  EXPECT_EQ(result.state, CalibrationState::kPaused);
  EXPECT_GT(result.ticks_used, 0U);
  EXPECT_EQ(result.bearings_used, 0U);
  calibrator.setPaused(false);
  EXPECT_NE(calibrator.result().state, CalibrationState::kPaused);
}

TEST(Calibrator, AWrongConfigurationListsAllErrors) {
  CalibratorConfig config = calibratorConfig();
  config.drive.wheel_separation_m = 0.0;
  config.filter.gate_probability = 2.0;
  config.converged.yaw_stddev_rad = -1.0;
  try {
    Calibrator calibrator(config);
    FAIL() << "no exception";
  } catch (const std::invalid_argument& error) {
    const std::string what = error.what();
    for (const char* name :
         {"wheels/separation", "filter/gate_probability", "converged/yaw_stddev"}) {
      EXPECT_NE(what.find(name), std::string::npos) << name << " not in: " << what;
    }
  }
}

}  // namespace
}  // namespace bearing_calibration::core
