// What the bearing adapter makes of poses and of laser scans calibrates a mount as well as the
// bound allows, and says how well.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iostream>
#include <optional>
#include <random>
#include <vector>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/input/point_bearing.h"
#include "bearing_calibration/input/scan_bearings.h"
#include "bearing_calibration/solve/observability.h"
#include "support/ray_traced_scan.h"
#include "support/simulated_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

using testing::Post;

constexpr int kStepsPerImage = 10;  // of 0.01 s
const double kStddev_rad = radiansFromDegrees(0.5);

/// A robot's true motion in steps of 0.01 s, from which a sensor's messages are made.
class Drive {
 public:
  explicit Drive(std::uint64_t seed) : simulated(paperCase(seed)) {
    simulated.looked_for = usualErrors();
    RobotConfig robot = simulated.robot;
    robot.steps_per_bearing = 1;
    RobotSimulator simulator(
        robot, {Light()},
        makeTrajectory(simulated.trajectory, robot.encoders.drive.wheel_separation_m));
    steps = record(&simulator, simulated.duration_s);
  }

  /// Between two steps on the chord of its arc, 4e-6 m beside it at most.
  Pose2 worldFromSensor(double time_s) const {
    const double step = time_s / simulated.robot.step_s;
    const auto before = static_cast<std::size_t>(step);
    const Pose2& from = steps.world_from_base[before];
    const Pose2& to = steps.world_from_base[std::min(before + 1, steps.world_from_base.size() - 1)];
    const double part = step - static_cast<double>(before);
    const Pose2 world_from_base{from.position_m + part * (to.position_m - from.position_m),
                                from.yaw_rad + part * wrapAngle(to.yaw_rad - from.yaw_rad)};
    return {world_from_base * simulated.robot.base_from_sensor.position_m,
            world_from_base.yaw_rad + simulated.robot.base_from_sensor.yaw_rad};
  }

  SimulatedCase simulated;
  SimulatedRecord steps;
};

using Adapted = std::function<BearingSet(const Drive&, Stamp, double time_s, std::mt19937*,
                                         const std::optional<BearingPrediction>&)>;

/// A marker 0.4 m above the sensor, in the optical frame of a camera that looks along the sensor's
/// x axis (REP 103: x to the right, y down, z ahead).
BearingSet fromPose(const Drive& drive, Stamp stamp, double time_s, std::mt19937* random,
                    const std::optional<BearingPrediction>&) {
  std::normal_distribution<double> gaussian;
  const Eigen::Vector2d place = drive.worldFromSensor(time_s).inverse() * Eigen::Vector2d::Zero();
  const double azimuth = std::atan2(place.y(), place.x()) + kStddev_rad * gaussian(*random);
  const double distance_m = place.norm() * (1.0 + 0.05 * gaussian(*random));
  const Eigen::Vector3d marker_in_optical(-distance_m * std::sin(azimuth), -0.4,
                                          distance_m * std::cos(azimuth));
  Eigen::Isometry3d sensor_from_optical = Eigen::Isometry3d::Identity();
  sensor_from_optical.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {stamp, {bearingOfPoint(sensor_from_optical * marker_in_optical, kStddev_rad)}};
}

/// A post at the origin, and others at `clutter`, by a scanner whose scans are turned by some noise
/// each.
BearingSet fromScan(const std::vector<Post>& posts, const Drive& drive, Stamp stamp, double time_s,
                    std::mt19937* random, const std::optional<BearingPrediction>& prediction) {
  std::normal_distribution<double> gaussian;
  const double turned_rad = kStddev_rad * gaussian(*random);
  LaserScan scan = testing::tracedScan(posts, stamp, [&](double after_s) {
    Pose2 world_from_sensor = drive.worldFromSensor(time_s + after_s);
    world_from_sensor.yaw_rad -= turned_rad;
    return world_from_sensor;
  });
  constexpr float kRangeStddev_m = 0.01F;
  for (float& range : scan.ranges_m)
    range += kRangeStddev_m * static_cast<float>(gaussian(*random));
  std::vector<TimedBearing> candidates;
  for (const ScanLight& light : lightsInScan(scan, {0.0, 0.2, 0.03, 0.2})) {
    const Eigen::Vector3d place(light.position_m.x(), light.position_m.y(), 0.0);
    candidates.push_back({bearingOfPoint(place, kStddev_rad), light.stamp});
    candidates.back().bearing.azimuth_variance_rad2 += edgeVariance(scan);
  }
  BearingSet set = atOneMoment(candidates, prediction);
  if (candidates.empty()) set.stamp = stamp;
  return set;
}

struct Outcome {
  CalibrationResult result;
  double chi_square = 0.0;
  Eigen::Vector3d stddev_per_bound = Eigen::Vector3d::Zero();
};

Outcome calibrate(std::uint64_t seed, const Adapted& adapted) {
  const Drive drive(seed);
  std::mt19937 random(static_cast<unsigned>(seed));
  CalibratorConfig config = testing::calibratorConfig();
  config.initializer.batch.errors = drive.simulated.looked_for;
  config.initializer.noise = usualNoise();
  Calibrator calibrator(config);
  SimulatedRecord seen;
  seen.ticks = drive.steps.ticks;
  const Stamp start = seen.ticks.front().stamp;
  for (std::size_t step = 0; step < seen.ticks.size(); ++step) {
    const WheelCounts& ticks = seen.ticks[step];
    calibrator.addTicks(ticks, ticks.stamp);
    if (step % kStepsPerImage != 0 || step + kStepsPerImage >= seen.ticks.size()) continue;
    const double time_s = secondsFromDuration(ticks.stamp - start);
    const BearingSet set =
        adapted(drive, ticks.stamp, time_s, &random, calibrator.predictBearing(ticks.stamp));
    calibrator.addBearings(set, set.stamp);
    seen.bearings.push_back(set);
    const double set_s = secondsFromDuration(set.stamp - start);
    seen.world_from_base.push_back(drive.worldFromSensor(set_s) *
                                   drive.simulated.robot.base_from_sensor.inverse());
  }
  Outcome outcome;
  outcome.result = calibrator.result();
  if (!outcome.result.base_from_sensor) return outcome;
  const MountEstimate& mount = *outcome.result.base_from_sensor;
  outcome.chi_square = testing::mountChiSquare(mount, drive.simulated.robot.base_from_sensor);
  const ObservationRun run = runFromRecord(drive.simulated, seen);
  std::vector<Eigen::Vector2d> lights;
  for (const Vector5& truth : run.truth) lights.push_back(truth.head<2>());
  const Matrix5 bound = cramerRaoBound(run.observations, lights, run.truth.back().tail<3>(),
                                       trueErrors(drive.simulated), drive.simulated.looked_for)
                            .cartesian()
                            .covariance;
  outcome.stddev_per_bound =
      mount.covariance.diagonal().cwiseSqrt().cwiseQuotient(bound.diagonal().tail<3>().cwiseSqrt());
  return outcome;
}

void expectHonestAndNearTheBound(const Adapted& adapted) {
  constexpr int kRuns = 20;
  constexpr double kMostPerBound = 1.3;
  double chi_square = 0.0;
  Eigen::Vector3d stddev_per_bound = Eigen::Vector3d::Zero();
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Outcome outcome = calibrate(seed, adapted);
    EXPECT_EQ(outcome.result.state, CalibrationState::kConverged)
        << seed << ": " << outcome.result.advice;
    chi_square += outcome.chi_square;
    stddev_per_bound += outcome.stddev_per_bound / kRuns;
  }
  const double degrees = 3.0 * kRuns;
  std::cout << "NEES " << chi_square / degrees << ", standard deviation over bound "
            << stddev_per_bound.transpose() << '\n';
  EXPECT_GT(chi_square, chiSquareQuantile(0.005, degrees));
  EXPECT_LT(chi_square, chiSquareQuantile(0.995, degrees));
  EXPECT_LT(stddev_per_bound.maxCoeff(), kMostPerBound);
}

TEST(AdaptedBearings, OfPosesAreAsGoodAsTheySay) { expectHonestAndNearTheBound(fromPose); }

TEST(AdaptedBearings, OfAPostInScansAreAsGoodAsTheySay) {
  expectHonestAndNearTheBound([](auto&&... how) { return fromScan({Post()}, how...); });
}

}  // namespace
}  // namespace bearing_calibration::core
