#pragma once

#include "bearing_calibration/planning/motion_primitive.h"

namespace bearing_calibration::core {

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
  /// Whether the wheels do something else than they are told: they roll the other way, or not.
  bool isDisobeyed(const WheelDisplacement& travelled) const;

 private:
  enum class Part : std::uint8_t { kTurning, kStraight, kDone };
  double targetOfPart() const;
  double progressOfPart(const WheelDisplacement& travelled) const;
  void nextPart(const WheelDisplacement& travelled);

  MotionPrimitive primitive_;
  WheelLimits limits_;
  Part part_ = Part::kTurning;
  WheelDisplacement part_start_;
  double part_time_s_ = 0.0;
  bool is_abandoned_ = false;
};

/// Commands that come to rest as fast as the acceleration allows.
WheelSpeeds braked(const WheelSpeeds& before, const WheelLimits& limits, double period_s);

inline bool isStanding(const WheelSpeeds& speeds) {
  return speeds.left_mps == 0.0 && speeds.right_mps == 0.0;
}

}  // namespace bearing_calibration::core
