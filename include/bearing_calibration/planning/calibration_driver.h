#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/planning/drive_end.h"
#include "bearing_calibration/planning/drive_motion.h"
#include "bearing_calibration/planning/motion_planner.h"
#include "bearing_calibration/planning/primitive_follower.h"

namespace bearing_calibration::core {

/// How long an input may be silent before the robot stops. Parameter group `timeouts`.
struct DriveTimeouts {
  double ticks_s = 0.0;
  double bearings_s = 0.0;
  double estimate_s = 0.0;

  void declare(Parameters& params);
};

/// Everything that a drive needs to know but what one is asked for.
struct DriveConfig {
  WheelLimits limits;
  SensingModel sensing;
  PlannerConfig planner;
  Region region;
  DriveTimeouts timeouts;

  void declare(Parameters& params);
};

/// What is asked for.
struct DriveGoal {
  static constexpr double kLeastTime_s = 1e-3;
  static constexpr double kMostTime_s = 86400.0;  ///< a day: longer than a battery lasts
  static constexpr double kLeastPath_m = 1e-3;
  static constexpr double kMostPath_m = 1e4;

  DriveMotion motion = DriveMotion::kOptimal;
  double max_time_s = 0.0;
  double max_path_m = 0.0;

  void declare(Parameters& params);
};

/// What the calibration last said, as far as driving needs it.
struct DriveEstimate {
  Stamp stamp;  ///< of the last fused bearing
  CalibrationState state = CalibrationState::kWaitingForTicks;
  std::optional<RobotEstimate> robot;  ///< at that stamp

  static DriveEstimate from(const CalibrationResult& result);
};

/// One drive of a robot that calibrates its sensor: wheel readings and the calibration's estimates
/// in, wheel speeds out, until the calibration has converged or something forbids to go on. Then it
/// brakes and stays. Reads no clock: every input comes with the time of its receipt.
class CalibrationDriver {
 public:
  /// @param moving  the last command of a drive that this one replaces: it brakes first, and
  ///                the start is where it then stands
  /// @throws std::invalid_argument with every sentence of errorsOf().
  CalibrationDriver(const DriveConfig& config, const DriveGoal& goal, Stamp now,
                    const WheelSpeeds& moving = {});
  ~CalibrationDriver();
  CalibrationDriver(CalibrationDriver&&) noexcept;
  CalibrationDriver& operator=(CalibrationDriver&&) noexcept;

  void addTravel(const WheelTravel& travel, Stamp received);
  void noteBearing(Stamp received);  ///< the light was seen
  void addEstimate(const DriveEstimate& estimate, Stamp received);

  /// Ends the drive for a reason from outside; the first reason stays.
  void end(DriveEnd reason);

  /// The command for the next moment. To be called at a steady rate of some 10 Hz or more.
  WheelSpeeds steer(Stamp now);

  DriveEnd ended() const;
  const WheelSpeeds& command() const;  ///< the last one
  bool standing() const;               ///< the last command was to stand
  double timeSeconds() const;
  double pathMeters() const;
  const Pose2& startFromBase() const;
  /// Corners of the way ahead, in the frame of the start; the base's place now is the first.
  std::vector<Pose2> wayAhead() const;
  /// What the plan promises; none in the opening and in scripted motions.
  const std::optional<PlannedPrimitive>& plan() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bearing_calibration::core
