#include "support/simulated_calibration.h"

#include <Eigen/Cholesky>
#include <map>
#include <memory>
#include <utility>

#include "bearing_calibration/simulation/trajectory.h"
#include "tools/study/default_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core::testing {
RobotConfig paperRobot(std::uint64_t seed) { return paperCase(seed).robot; }

CalibratorConfig calibratorConfig() {
  const EncoderConfig encoders = paperCase(1).robot.encoders;
  CalibratorConfig config = defaultCalibration(encoders.drive, encoders.noise);
  config.bearings.reorder_window_s = 0.0;  // a bearing is taken in with the last ticks of a test
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

}  // namespace bearing_calibration::core::testing
