#include "support/simulated_calibration.h"

#include <Eigen/Cholesky>
#include <map>
#include <memory>
#include <utility>

#include "bearing_calibration/simulation/trajectory_config.h"

namespace bearing_calibration::testing {
namespace {

DriveGeometry paperDrive() {
  constexpr double kTick_m = 1e-5;
  DriveGeometry drive;
  drive.wheel_separation_m = 0.25;
  drive.left_wheel_radius_m = 0.05;
  drive.right_wheel_radius_m = 0.05;
  drive.ticks_per_revolution = 2.0 * kPi * drive.left_wheel_radius_m / kTick_m;
  drive.counter_bits = 32;
  drive.max_wheel_speed_mps = 1.0;
  return drive;
}

const WheelNoise kPaperNoise{1e-6, 0.0};

}  // namespace

RobotConfig paperRobot(std::uint64_t seed) {
  constexpr double kPhi = kPi / 6.0;
  constexpr double kRho_m = 0.1;
  RobotConfig robot;
  robot.encoders.drive = paperDrive();
  robot.encoders.noise = kPaperNoise;
  robot.base_from_sensor = {kRho_m * Eigen::Vector2d(std::cos(kPhi), std::sin(kPhi)), 2.0 * kPhi};
  robot.world_from_start = {{2.0, 0.0}, 0.5 * kPi};
  robot.sensor.stddev_rad = radiansFromDegrees(1.0);
  robot.seed = seed;
  return robot;
}

CalibratorConfig calibratorConfig() {
  CalibratorConfig config;
  config.drive = paperDrive();
  config.wheel_noise = kPaperNoise;
  config.tick_history_s = 5.0;
  config.bearings.max_stddev_rad = 0.5;
  config.bearings.max_future_s = 0.5;
  config.bearings.max_waiting = 100;
  config.filter.gate_probability = 0.999;
  config.filter.recovery_after = 5;
  config.filter.recovery_bearing_stddev_rad = radiansFromDegrees(10.0);
  config.filter.recovery_distance_stddev_m = 0.03;
  config.converged.position_stddev_m = 0.01;
  config.converged.yaw_stddev_rad = radiansFromDegrees(0.5);
  return config;
}

SimulatedRecord simulate(const RobotConfig& robot, double duration_s) {
  RobotSimulator simulator(robot, {Light{}},
                           makeTrajectory({}, robot.encoders.drive.wheel_separation_m));
  return record(&simulator, duration_s);
}

CalibrationResult play(const SimulatedRecord& record, Calibrator* calibrator,
                       const std::vector<double>& arrival_delays_s, double from_s, double to_s) {
  const Stamp start = record.ticks.front().stamp;
  const auto within = [&](Stamp moment) {
    const double time_s = secondsFromDuration(moment - start);
    return time_s >= from_s && time_s < to_s;
  };
  std::multimap<Stamp, const BearingSet*> arrivals;
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    const double delay_s = arrival_delays_s[i % arrival_delays_s.size()];
    if (!within(record.bearings[i].stamp)) continue;
    arrivals.emplace(record.bearings[i].stamp + durationFromSeconds(delay_s), &record.bearings[i]);
  }
  auto next = arrivals.begin();
  for (const WheelCounts& ticks : record.ticks) {
    for (; next != arrivals.end() && next->first <= ticks.stamp; ++next) {
      calibrator->addBearings(*next->second, next->first);
    }
    if (within(ticks.stamp)) calibrator->addTicks(ticks, ticks.stamp);
  }
  for (; next != arrivals.end(); ++next) calibrator->addBearings(*next->second, next->first);
  return calibrator->result();
}

double mountChiSquare(const MountEstimate& estimate, const Pose2& truth) {
  Eigen::Vector3d error;
  error << estimate.mean.head<2>() - truth.position_m, wrapAngle(estimate.mean.z() - truth.yaw_rad);
  return error.dot(estimate.covariance.ldlt().solve(error));
}

}  // namespace bearing_calibration::testing
