#include "support/sensed_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <vector>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/solve/observability.h"
#include "support/simulated_calibration.h"

namespace bearing_calibration::core::testing {
namespace {

constexpr int kStepsPerImage = 10;  // of 0.01 s

struct Outcome {
  CalibrationResult result;
  double chi_square = 0.0;
  Eigen::Vector3d stddev_per_bound = Eigen::Vector3d::Zero();
};

Outcome calibrate(std::uint64_t seed, const Sensed& sensed) {
  const SensedDrive drive(seed);
  std::mt19937 random(static_cast<unsigned>(seed));
  CalibratorConfig config = calibratorConfig();
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
        sensed(drive, ticks.stamp, time_s, &random, calibrator.predictBearing(ticks.stamp));
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
  outcome.chi_square = mountChiSquare(mount, drive.simulated.robot.base_from_sensor);
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

}  // namespace

SensedDrive::SensedDrive(std::uint64_t seed) : simulated(paperCase(seed)) {
  simulated.looked_for = usualErrors();
  RobotConfig robot = simulated.robot;
  robot.steps_per_bearing = 1;
  RobotSimulator simulator(
      robot, {Light()},
      makeTrajectory(simulated.trajectory, robot.encoders.drive.wheel_separation_m));
  steps = record(&simulator, simulated.duration_s);
}

Pose2 SensedDrive::worldFromSensor(double time_s) const {
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

void expectHonestAndNearTheBound(const Sensed& sensed) {
  constexpr int kRuns = 20;
  constexpr double kMostPerBound = 1.3;
  constexpr double kMostChiSquare = 25.0;
  double chi_square = 0.0;
  Eigen::Vector3d stddev_per_bound = Eigen::Vector3d::Zero();
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const Outcome outcome = calibrate(seed, sensed);
    EXPECT_EQ(outcome.result.state, CalibrationState::kConverged)
        << seed << ": " << outcome.result.advice;
    EXPECT_LT(outcome.chi_square, kMostChiSquare) << seed;
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

}  // namespace bearing_calibration::core::testing
