#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/judge/calibration_state.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/planning/drive_script.h"
#include "bearing_calibration/planning/motion_planner.h"

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
  double min_probability = 0.0;  ///< candidates of a lower one are no light, as to the calibration

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

/// Why a drive has ended; the values are those of CalibrationDrive.action.
enum class DriveEnd : std::uint8_t {
  kNone,       ///< it goes on
  kConverged,  ///< the calibration called itself converged
  kCancelled,
  kDisabled,         ///< the enabling input says no
  kObstacle,         ///< the obstacle input says yes
  kTicksLost,        ///< no wheel readings for too long
  kLightLost,        ///< no bearing for too long
  kEstimateLost,     ///< the calibration is silent
  kClockLost,        ///< time stands still, or jumps
  kLeftRegion,       ///< the base's centre is outside of the region
  kNoWay,            ///< every way would lead too near to a light or out of the region
  kWheelsDisobeyed,  ///< they do not roll as commanded
  kTimeOver,
  kPathOver,
  kShutDown,      ///< the process of the drive node is about to end
  kEnableLost,    ///< the enabling input is silent
  kObstacleLost,  ///< the obstacle input is silent
  kFailed,        ///< an error inside of the drive node
};

const char* nameOf(DriveEnd end);    ///< "CONVERGED" and so on
const char* describe(DriveEnd end);  ///< a sentence for people: what happened, and what to do

/// What the calibration last said, as far as driving needs it.
struct DriveEstimate {
  Stamp stamp;  ///< of the last fused bearing
  CalibrationState state = CalibrationState::kWaitingForTicks;
  /// At that stamp, withoutNearness(); of its lights the first is driven by, and all are kept away
  /// from.
  std::optional<StateEstimate> robot;
  double nearness_stddev_m = 0.0;  ///< of the sensor
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

  void addTravel(const WheelTravel& travel, Stamp received);
  /// What an image of the sensor, or a scan, shows: whether it saw the light, and what it can see.
  void addBearings(const BearingSet& bearings, Stamp received);
  void addEstimate(const DriveEstimate& estimate, Stamp received);

  /// Ends the drive for a reason from outside; the first reason stays.
  void end(DriveEnd reason);

  /// The command for the next moment. To be called at a steady rate of some 10 Hz or more.
  /// @param real_period_s  since the last call, by a clock that never stands still nor jumps:
  ///                       braking goes by it where `now` has moved on by less
  WheelSpeeds steer(Stamp now, double real_period_s = 0.0);

  DriveEnd ended() const { return ended_; }
  bool standing() const { return isStanding(command_); }   ///< the last command was to stand
  const WheelSpeeds& command() const { return command_; }  ///< the last one
  double timeSeconds() const { return time_s_; }
  double pathMeters() const { return path_m_; }
  const Pose2& startFromBase() const { return start_from_base_; }
  /// Corners of the way ahead, in the frame of the start; the base's place now is the first.
  std::vector<Pose2> wayAhead() const;
  /// What the plan promises; none in the opening and in scripted motions.
  const std::optional<PlannedPrimitive>& plan() const { return plan_; }

 private:
  /// An estimate and the last fused bearing's stamp, at which it is.
  struct Known {
    Stamp stamp;
    StateEstimate estimate;
  };

  bool isPlanned() const { return goal_.motion == DriveMotion::kOptimal; }
  void watch(Stamp now, double period_s, double jump_s);
  bool isLightDue() const;
  void useEstimate();
  std::optional<StateEstimate> estimateNow() const;
  bool isAllowed(const MotionPrimitive& primitive,
                 const std::optional<StateEstimate>& estimate) const;
  void decide();
  void keepAway();

  DriveConfig config_;
  DriveGoal goal_;
  MotionPlanner planner_;
  DriveScript script_;
  OdometryTrack track_;  ///< anchored at known_'s stamp
  FieldOfView view_;
  Stamp began_;
  Stamp last_steered_ = began_, last_travel_ = began_, last_estimate_ = began_;
  bool is_calibration_heard_ = false;
  Stamp last_image_ = began_;
  Stamp last_bearing_ = began_;     ///< or the last moment at which none was due
  double turned_unseen_rad_ = 0.0;  ///< since a bearing, either way

  DriveEnd ended_ = DriveEnd::kNone;
  WheelSpeeds command_;
  bool has_stood_;  ///< where it does so first is the start
  Pose2 start_from_base_;
  double time_s_ = 0.0;
  double path_m_ = 0.0;
  WheelDisplacement travelled_;
  double turned_rad_ = 0.0;       ///< since the start, full turns too
  std::optional<Known> waiting_;  ///< for the readings that cover it
  std::optional<Known> known_;
  bool is_taken_back_ = false;  ///< it is no longer planned with, but its light is kept away from
  std::optional<PlannedPrimitive> plan_;
  std::optional<PrimitiveFollower> follower_;
};

}  // namespace bearing_calibration::core
