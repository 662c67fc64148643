#pragma once

#include <optional>
#include <string>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_readings.h"

namespace bearing_calibration::core {

/// The positions that a wheel's joint has had. While all of them, and zero, lie within one turn,
/// the joint may be one that wraps, at +-pi or from 2 pi to 0: it is taken the shorter way round. A
/// cumulative joint leaves one turn soon, and is taken as it says from then on.
class JointRange {
 public:
  void add(double position_rad);
  /// How far it has turned from one position to the next one.
  double turn(double from_rad, double to_rad) const;

 private:
  double least_rad_ = 0.0;
  double most_rad_ = 0.0;
};

/// Wheel readings, as they come from the encoders, to the travel of each wheel since the first one.
///
/// What the wheels cannot have done since the last reading, at DriveGeometry::max_wheel_speed_mps,
/// is not motion: a jump to near zero is a reset by the driver; any other jump is refused, and
/// followed when the next reading confirms it. Whatever motion such a break hides is unknown: it
/// enters the travel as zero, with the variance of all that was possible. A joint's jump of nearly
/// one turn that leaves motion is a wrap, as long as the joint has never left one turn (see
/// JointRange).
///
/// Odometry's poses become the wheels' travel on the arc from one to the next. A base that moves
/// sideways does not move on its wheels: that, too, is refused, and followed when it persists.
/// Poses that stand while the twist beside them moves come from a driver that does not integrate.
///
/// A clock that steps back, as network time does, makes stamps pass twice. Readings are refused
/// until they overtake the last one; then the counters have all the motion, and the wheels had the
/// time of the refused readings for it, too.
class WheelOdometer {
 public:
  explicit WheelOdometer(const DriveGeometry& geometry) : geometry_(geometry) {}

  /// What became of the reading. travel() has moved to its stamp when the outcome is kAccepted,
  /// kCounterReset or kTicksGap, and is unchanged otherwise.
  InputOutcome add(const WheelCounts& ticks);
  InputOutcome add(const WheelAngles& angles);
  InputOutcome add(const OdometryPose& odometry);

  const std::optional<WheelTravel>& travel() const { return travel_; }

  /// Tells of a reading that somebody before (see WheelPairing) has refused as kStampNotAfterLast.
  void noteLate(Stamp stamp);
  /// Readings that follow each other lie before travel(): the clock of their stamps has stepped
  /// back.
  bool isSteppedBack() const { return late_ && late_->count > 1; }

 private:
  /// A reading of any kind; the unused ones stay zero.
  struct Reading {
    WheelCounts ticks;
    WheelAngles angles;
    Pose2 start_from_base;
    Stamp stamp;
    bool is_pose = false;
  };

  /// Stamps of readings in a row that were refused as late, each after the one before.
  struct LateRow {
    Stamp first;
    Stamp last;
    int count = 0;
  };

  InputOutcome addReading(const Reading& reading);
  /// @param refusal  what becomes of the reading if nothing explains its jump
  InputOutcome resolveJump(const Reading& reading, const InputOutcome& refusal);
  bool standsAgainstItsTwist(const OdometryPose& odometry);
  WheelDisplacement displacement(const Reading& from, const Reading& to) const;
  /// By how much farther across its arc the base has moved than any driver's way to integrate makes
  /// it [m].
  static double sidewaysStep(const Reading& from, const Reading& to);
  /// The wheels may have moved so.
  bool isPossible(const Reading& from, const Reading& to) const;
  /// Farther, and a counter, a joint or a heading may have wrapped unseen [m].
  double farthestCertain(const Reading& from, const Reading& to) const;
  /// The longest that the wheels may have turned from one reading to a later one.
  double timeBetween(const Reading& from, const Reading& to) const;
  /// The farthest that a wheel can roll from one reading to a later one, as read.
  double reach(const Reading& from, const Reading& to) const;
  void moveTo(const Reading& reading, const WheelDisplacement& wheels);
  void moveUnseenTo(const Reading& reading);

  DriveGeometry geometry_;
  std::optional<WheelTravel> travel_;
  JointRange left_joint_;
  JointRange right_joint_;
  Reading last_;                       ///< the reading that travel_ stands at
  std::optional<Reading> refused_;     ///< a jump that waits for its confirmation
  std::optional<LateRow> late_;        ///< since the last reading that was taken
  double sideways_m_ = 0.0;            ///< of the base, in the last second or so
  std::optional<std::string> frames_;  ///< of the first odometry
  Stamp last_twist_;
  double twist_travel_m_ = 0.0;  ///< by the twist, since the pose has changed
};

}  // namespace bearing_calibration::core
