#pragma once

#include <Eigen/Core>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core {

/// What the wheels may do. Parameter group `limits`.
struct WheelLimits {
  double wheel_separation_m = 0.0;
  double max_speed_mps = 0.0;  ///< of each wheel
  double max_acceleration_mps2 = 0.0;

  void declare(Parameters& params);
};

/// Where the base's centre may go, in the base frame of the start. Parameter group `region`.
struct Region {
  double radius_m = 0.0;  ///< disc about the start; used without a polygon
  /// Corners in either order [m]; at least three, or none for the disc. The start must lie inside.
  std::vector<Eigen::Vector2d> polygon_m;

  void declare(Parameters& params);

  /// Least distance of a straight way to the border [m], negative when a part of it lies outside:
  /// minus that of its end which does, or a nanometre where it only touches or crosses the border.
  double clearance(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;
  double clearance(const Eigen::Vector2d& point) const { return clearance(point, point); }
};

/// The motion primitive of a differential drive: turn on the spot, then go straight, from
/// standstill to standstill. Both parts may be empty. Backwards is a negative length.
struct MotionPrimitive {
  double turn_rad = 0.0;  ///< counter-clockwise, by any number of full turns
  double length_m = 0.0;
};

/// The base's pose after a primitive, in the frame that `frame_from_base` is given in.
Pose2 poseAfter(const MotionPrimitive& primitive, const Pose2& frame_from_base);

/// What the wheels roll in each of a primitive's two parts.
WheelDisplacement turningWheels(const MotionPrimitive& primitive, double wheel_separation_m);
WheelDisplacement straightWheels(const MotionPrimitive& primitive);

/// A wheel that is so near to the end of a part [m] has arrived: what is left is corrected by the
/// next decision.
inline constexpr double kArrived_m = 1e-3;
/// The primitive as it is driven: without the parts that have arrived before they begin.
MotionPrimitive driveable(const MotionPrimitive& primitive, double wheel_separation_m);

/// Least time for a wheel to roll `distance_m` from standstill to standstill [s].
double travelTime(double distance_m, const WheelLimits& limits);
/// How far it has come after `time_s` of that: speeds up, cruises, brakes.
double travelAt(double time_s, double distance_m, const WheelLimits& limits);

/// Time of a whole primitive, both parts [s].
double durationOf(const MotionPrimitive& primitive, const WheelLimits& limits);

/// Commands that come to rest as fast as the acceleration allows.
WheelSpeeds braked(const WheelSpeeds& before, const WheelLimits& limits, double period_s);

inline bool isStanding(const WheelSpeeds& speeds) {
  return speeds.left_mps == 0.0 && speeds.right_mps == 0.0;
}

/// Steers the wheels through one primitive by what they have rolled so far: never faster, never
/// with more acceleration than the limits allow, and slow enough to stop at the end of each part.
class PrimitiveFollower {
 public:
  /// @param travelled  where the wheels stand at the beginning
  PrimitiveFollower(const MotionPrimitive& primitive, const WheelLimits& limits,
                    const WheelDisplacement& travelled);

  /// The next command, after the one before it has been driven for `period_s`.
  WheelSpeeds steer(const WheelDisplacement& travelled, const WheelSpeeds& before, double period_s);
  /// Brakes at once; done when it stands.
  void abandon() { is_abandoned_ = true; }

  bool done() const { return part_ == Part::kDone; }
  /// What remains of the primitive.
  MotionPrimitive remaining(const WheelDisplacement& travelled) const;
  /// Whether the wheels do something else than they are told: they roll the other way, or one of
  /// them does not roll.
  bool isDisobeyed(const WheelDisplacement& travelled) const;

 private:
  enum class Part { kTurning, kStraight, kDone };
  double targetOfPart() const;
  double leftOfPart(const WheelDisplacement& travelled) const;
  void nextPart(const WheelDisplacement& travelled);

  MotionPrimitive primitive_;
  WheelLimits limits_;
  Part part_ = Part::kTurning;
  WheelDisplacement part_start_;
  double part_time_s_ = 0.0;
  WheelDisplacement last_moved_;
  double still_s_ = 0.0;  ///< since both wheels have moved from there
  bool is_abandoned_ = false;
};

}  // namespace bearing_calibration::core
