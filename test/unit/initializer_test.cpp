#include "bearing_calibration/init/initializer.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/init/start_candidates.h"
#include "bearing_calibration/init/start_obstacle.h"
#include "bearing_calibration/simulation/trajectory.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using Kind = TrajectoryConfig::Kind;

constexpr double kHonest = 25.0;  // chi-square of 3 degrees: beyond it in 1.5 of 100 000

double mountChiSquare(const CartesianEstimate& estimate, const Vector5& truth) {
  Vector5 error = estimate.mean - truth;
  error(4) = wrapAngle(error(4));
  const Eigen::Vector3d mount_error = error.tail<3>();
  const Eigen::Matrix3d covariance = estimate.covariance.bottomRightCorner<3, 3>();
  return mount_error.dot(covariance.ldlt().solve(mount_error));
}

ObservationRun paperRun(Kind kind, double duration_s, std::uint64_t seed = 1) {
  SimulatedCase simulated = paperCase(seed);
  simulated.trajectory.kind = kind;
  simulated.duration_s = duration_s;
  return simulate(simulated);
}

StartObstacle obstacleOf(Kind kind) {
  return findStart(paperRun(kind, 60.0).observations, InitializerConfig()).obstacle;
}

TEST(Initializer, SaysWhatTheMotionLacks) {
  EXPECT_EQ(findStart({}, InitializerConfig()).obstacle, StartObstacle::kTooFewObservations);
  EXPECT_EQ(obstacleOf(Kind::kStanding), StartObstacle::kTooShortPath);
  EXPECT_EQ(obstacleOf(Kind::kSpin), StartObstacle::kTooShortPath);
  EXPECT_EQ(obstacleOf(Kind::kCircle), StartObstacle::kOneCurvature);
  const StartObstacle line = obstacleOf(Kind::kLine);  // its noise turns a little
  EXPECT_TRUE(line == StartObstacle::kNoTurn || line == StartObstacle::kOneCurvature)
      << nameOf(line);
}

// A random walk's extent is hardly ever 4.5 times its noise: five times are a way that was driven.
TEST(Initializer, APathIsOneThatNoiseDoesNotMake) {
  MotionSummary motion;
  motion.turn_rad = motion.second_curvature_m = 1.0;
  motion.extent_noise_m = 0.02;
  motion.extent_m = 5.01 * motion.extent_noise_m;
  EXPECT_EQ(motionObstacle(StartLimits::kMinObservations, motion), StartObstacle::kNone);
  motion.extent_m = 4.99 * motion.extent_noise_m;
  EXPECT_EQ(motionObstacle(StartLimits::kMinObservations, motion), StartObstacle::kTooShortPath);
  motion.extent_m = 0.41;  // of any robot, with wheels of any noise
  motion.extent_noise_m = 1.0;
  EXPECT_EQ(motionObstacle(StartLimits::kMinObservations, motion), StartObstacle::kNone);
}

/// What a good fit lacks whose light, 1.5 m away, and mount are known to these standard deviations.
StartObstacle obstacleWith(double extent_m, const Vector5& stddev) {
  BatchEstimate fit;
  fit.converged = true;
  fit.chi_square = fit.degrees_of_freedom = 100;
  fit.nis.assign(105, 1.0);
  CartesianEstimate light_and_mount;
  light_and_mount.mean << 1.5, 0.0, 0.0, 0.0, 0.0;
  light_and_mount.covariance.diagonal() = stddev.cwiseAbs2();
  StartAttempt attempt;
  attempt.estimate = StateEstimate::of(light_and_mount);
  attempt.motion.extent_m = extent_m;
  attempt.motion.path_m = 1.0;
  attempt.rival.gap = 100.0;
  return answerObstacle(attempt, fit, InitializerConfig());
}

TEST(Initializer, OnASmallPathThePlaceMustBeKnownBetter) {
  const auto obstacle = [](double extent_m, double position_stddev_m) {
    Vector5 stddev = Vector5::Zero();
    stddev.segment<2>(CartesianIndex::kSensorX).setConstant(position_stddev_m);
    return obstacleWith(extent_m, stddev);
  };
  EXPECT_EQ(obstacle(1.0, 0.029), StartObstacle::kNone);
  EXPECT_EQ(obstacle(1.0, 0.031), StartObstacle::kWeakDirection);
  EXPECT_EQ(obstacle(0.2, 0.019), StartObstacle::kNone);
  EXPECT_EQ(obstacle(0.2, 0.021), StartObstacle::kWeakDirection);
}

// A filter is linear about a light that it knows to 0.15 of its distance, in its worst direction.
TEST(Initializer, TheLightMustBeKnownAlongAndAcross) {
  constexpr double kMost_m = 0.15 * 1.5;
  for (const int direction : {CartesianIndex::kLightX, CartesianIndex::kLightY}) {
    EXPECT_EQ(obstacleWith(1.0, 0.99 * kMost_m * Vector5::Unit(direction)), StartObstacle::kNone);
    EXPECT_EQ(obstacleWith(1.0, 1.01 * kMost_m * Vector5::Unit(direction)),
              StartObstacle::kWeakDirection);
  }
}

TEST(Initializer, IsReadyAndHonestOnThePapersDance) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ObservationRun run = paperRun(Kind::kDance, 30.0, seed);
    const StartAttempt attempt = findStart(run.observations, InitializerConfig());
    ASSERT_TRUE(attempt.ready()) << "seed " << seed << ": " << nameOf(attempt.obstacle);
    EXPECT_LT(mountChiSquare(attempt.estimate.cartesian(), run.truth.back()), kHonest)
        << "seed " << seed;
    EXPECT_GT(2.0 * attempt.rival.gap, StartLimits::kMinRunnerUpMargin);
  }
}

/// A robot that drives again and again 6 cm to and fro, turning in between.
ObservationRun smallRun(std::uint64_t seed, double wheel_noise_m, double light_distance_m = 0.6) {
  constexpr double kSpeed_mps = 0.1;
  const DriveSegment leg{kSpeed_mps, kSpeed_mps, 0.6};
  const DriveSegment turn{-kSpeed_mps, kSpeed_mps, 1.0};
  SimulatedCase simulated = paperCase(seed);
  simulated.robot.encoders.drive.wheel_separation_m = 0.088;
  simulated.robot.encoders.noise.independent_k_m = wheel_noise_m;
  simulated.robot.world_from_start.position_m = {light_distance_m, 0.0};
  simulated.duration_s = 60.0;
  return simulateAlong(simulated, segmentTrajectory({leg, turn}));
}

TEST(Initializer, ASmallPathIsEnoughWhereItTellsTheMount) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ObservationRun run = smallRun(seed, 1e-6);
    const StartAttempt attempt = findStart(run.observations, InitializerConfig());
    EXPECT_LT(attempt.motion.extent_m, StartLimits::kMinExtent_m);
    ASSERT_TRUE(attempt.ready()) << "seed " << seed << ": " << nameOf(attempt.obstacle);
    EXPECT_LT(mountChiSquare(attempt.estimate.cartesian(), run.truth.back()), kHonest)
        << "seed " << seed;
  }
}

// With so much noise in its wheels the same path may be all noise.
TEST(Initializer, ASmallPathIsNotBelievedOfWheelsWithMuchNoise) {
  const StartAttempt attempt = findStart(smallRun(1, 1e-3).observations, InitializerConfig());
  EXPECT_EQ(attempt.obstacle, StartObstacle::kTooShortPath);
}

// Nor where the light is so far away that all bearings are taken from about one place.
TEST(Initializer, ASmallPathIsNotEnoughForAFarLight) {
  constexpr double kFar_m = 1.5;
  EXPECT_EQ(findStart(smallRun(1, 1e-6, kFar_m).observations, InitializerConfig()).obstacle,
            StartObstacle::kTooShortPath);
}

// Whoever turns on the spot and drives straight sees a far light as one that stands where he has
// turned.
TEST(Initializer, AFarLightIsNotBelievedToBeWhereTheRobotHasTurned) {
  constexpr double kSpeed_mps = 0.2;
  const DriveSegment leg{kSpeed_mps, kSpeed_mps, 3.0};
  const DriveSegment turn{-kSpeed_mps, kSpeed_mps, 2.0};
  const std::vector<std::vector<DriveSegment>> drives = {{turn, turn, leg, turn, leg},
                                                         {leg, turn, leg, turn}};
  const RandomCaseRange far{0.5, 2.5, 6.0};
  InitializerConfig config;
  config.batch.errors = usualErrors();
  int too_near = 0;
  for (const std::vector<DriveSegment>& drive : drives) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
      SimulatedCase simulated = randomCase(seed, Kind::kStanding, far);
      for (const double duration_s : {6.5, 9.5}) {
        simulated.duration_s = duration_s;
        const ObservationRun run = simulateAlong(simulated, segmentTrajectory(drive));
        const StartAttempt attempt = findStart(run.observations, config);
        if (attempt.obstacle == StartObstacle::kLightTooNear) ++too_near;
        if (!attempt.ready()) continue;
        EXPECT_LT(mountChiSquare(attempt.estimate.cartesian(), run.truth.back()), kHonest)
            << "seed " << seed << ", " << duration_s << " s";
      }
    }
  }
  EXPECT_GT(too_near, 0);
}

// A spin's path is its wheels' noise, however long it lasts.
TEST(Initializer, ASpinsNoiseIsNoPath) {
  SimulatedCase simulated = paperCase(1);
  simulated.trajectory.kind = Kind::kSpin;
  simulated.duration_s = 60.0;
  simulated.robot.encoders.noise.independent_k_m = 1e-4;
  const std::vector<Observation> observations = simulate(simulated).observations;
  const MotionSummary motion = summariseMotion(observations);
  EXPECT_GT(motion.extent_m, motion.extent_noise_m);
  EXPECT_EQ(findStart(observations, InitializerConfig()).obstacle, StartObstacle::kTooShortPath);
}

TEST(IsSameMount, OnASmallPathTwoPlacesCloseToEachOtherAreTwo) {
  Vector5 near = Vector5::Zero();
  near(CartesianIndex::kSensorX) = 0.06;
  EXPECT_TRUE(isSameMount(Vector5::Zero(), near, sameMountWithin(1.0)));
  EXPECT_FALSE(isSameMount(Vector5::Zero(), near, sameMountWithin(0.17)));
}

TEST(Initializer, TheSameRecordGivesTheSameAnswer) {
  const ObservationRun run = paperRun(Kind::kDance, 30.0);
  const StartAttempt first = findStart(run.observations, InitializerConfig());
  const StartAttempt second = findStart(run.observations, InitializerConfig());
  EXPECT_EQ(first.estimate.mean, second.estimate.mean);
  EXPECT_EQ(first.estimate.covariance, second.estimate.covariance);
}

// Turning every bearing turns the sensor's yaw and nothing else.
TEST(Initializer, TurnedBearingsTurnTheYawAlone) {
  ObservationRun run = paperRun(Kind::kDance, 30.0);
  const StartAttempt straight = findStart(run.observations, InitializerConfig());
  ASSERT_TRUE(straight.ready());
  for (int turn_deg = 30; turn_deg < 360; turn_deg += 30) {
    std::vector<Observation> turned = run.observations;
    const double turn = radiansFromDegrees(turn_deg);
    for (Observation& observation : turned)
      observation.azimuth_rad = wrapAngle(observation.azimuth_rad - turn);
    const StartAttempt attempt = findStart(turned, InitializerConfig());
    ASSERT_TRUE(attempt.ready()) << turn_deg;
    const Vector5 change = attempt.estimate.cartesian().mean - straight.estimate.cartesian().mean;
    EXPECT_LT(change.head<4>().norm(), 1e-4) << turn_deg;
    EXPECT_NEAR(wrapAngle(change(4) - turn), 0.0, 1e-4) << turn_deg;
  }
}

/// A drive of 5 m with an hour of standing or spinning in its middle. Neither half is enough.
ObservationRun interruptedRun(const DriveSegment& pause) {
  constexpr double kSpeed_mps = 0.2;
  const DriveSegment straight{kSpeed_mps, kSpeed_mps, 5.0};
  const DriveSegment spin{-kSpeed_mps, kSpeed_mps, 1.0};
  const DriveSegment end{0.0, 0.0, 1e6};
  SimulatedCase simulated = paperCase(5);
  simulated.duration_s = 2.0 * (straight.duration_s + spin.duration_s) + pause.duration_s;
  return simulateAlong(simulated, segmentTrajectory({straight, spin, pause, straight, spin, end}));
}

void expectNoMotionForgotten(const DriveSegment& pause) {
  const ObservationRun run = interruptedRun(pause);
  Initializer initializer{InitializerConfig()};
  std::size_t most = 0;
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    initializer.add(run.observations[i]);
    most = std::max(most, initializer.record().observations().size());
    constexpr std::size_t kObservationsOfFirstPart = 60;
    if (i == kObservationsOfFirstPart) {
      EXPECT_FALSE(initializer.attempt().ready());
    }
  }
  EXPECT_LE(most, ObservationRecordConfig().capacity);
  const StartAttempt attempt = initializer.attempt();
  EXPECT_GT(attempt.motion.extent_m, 1.0);  // of two straight pieces of 1 m
  ASSERT_TRUE(attempt.ready()) << nameOf(attempt.obstacle);
  EXPECT_LT(mountChiSquare(attempt.estimate.cartesian(), run.truth.back()), kHonest);
}

TEST(Initializer, AnHourOfStandingForgetsNoMotion) { expectNoMotionForgotten({0.0, 0.0, 3600.0}); }

TEST(Initializer, AnHourOfSpinningForgetsNoMotion) { expectNoMotionForgotten({-0.2, 0.2, 3600.0}); }

TEST(Initializer, RefusesAConfigurationThatCannotBe) {
  InitializerConfig config;
  config.min_inlier_fraction = 1.5;
  config.batch.slip_gain = -1.0;
  EXPECT_EQ(errorsOf(config).size(), 2U);
  EXPECT_THROW(Initializer{config}, std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
