#pragma once

#include <functional>

#include "bearing_calibration/output/result.h"
#include "bearing_calibration/planning/calibration_driver.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// A robot that drives its own calibration, from the simulator's sensors to its wheels.
struct DrivenCase {
  SimulatedCase simulated;  ///< its trajectory plays no part
  DriveConfig drive;
  DriveGoal goal;
  bool stops_when_converged = true;  ///< else it drives on until the goal's time is over
  FieldOfView view = {};             ///< of the sensor
  bool is_view_known = true;         ///< the sensor says it
  /// What sees the light when bearings are due; the simulator's own bearing sensor when empty.
  std::function<BearingSet(const RobotSimulator&)> look;
};

/// The parameters of config/drive.yaml for the paper's robot, in a room of 4 m about its start.
DriveConfig paperDrive();

/// With a limit of 0.5 m for the estimate, the true distance must not fall below this one.
inline constexpr double kNear_m = 0.45;

/// How a drive went.
struct DriveRecord {
  DriveEnd end = DriveEnd::kNone;
  double time_s = 0.0;
  double path_m = 0.0;
  double first_estimate_s = 0.0;  ///< after the start; infinite without any
  double least_distance_m = 0.0;  ///< of the base's centre to the light, truly
  /// The same from the moment on at which the driver had an estimate and was no nearer than
  /// kNear_m: what the opening has done, when nothing was known, is not the planner's.
  double least_kept_distance_m = 0.0;
  CalibrationResult result;
  Vector5 truth = Vector5::Zero();  ///< at the last bearing
  double worst_decision_ms = 0.0;   ///< processor time of the longest call of steer()
  int images = 0;
  int images_with_light = 0;
};

DriveRecord drive(const DrivenCase& driven);

/// det cov(phi deg, rho mm, psi deg)^(1/6) of a mount's covariance, the measure of driving.md.
double polarFigure(const Eigen::Matrix3d& mount_covariance, double rho_m);

}  // namespace bearing_calibration::core
