#include "bearing_calibration/planning/primitive_follower.h"

#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {
namespace {

/// Share of the acceleration that braking for the end plans with: wheels answer late.
constexpr double kBrakingShare = 0.7;
/// A wheel may lag behind or roll back so far [m] before it is said to disobey.
constexpr double kPatience_m = 0.1;
/// ... or a part of a primitive may take so many times its duration, and so much longer [s].
constexpr double kPatienceFactor = 3.0;
constexpr double kPatience_s = 3.0;

double approach(double value, double target, double most) {
  return value + std::clamp(target - value, -most, most);
}

}  // namespace

WheelSpeeds braked(const WheelSpeeds& before, const WheelLimits& limits, double period_s) {
  const double fastest = std::max(std::abs(before.left_mps), std::abs(before.right_mps));
  constexpr double kRounding_mps = 1e-9;
  if (fastest <= limits.max_acceleration_mps2 * period_s + kRounding_mps) return {};
  // both by the same factor: the curvature stays, the faster wheel brakes with the full
  // acceleration
  const double factor = 1.0 - limits.max_acceleration_mps2 * period_s / fastest;
  return {factor * before.left_mps, factor * before.right_mps};
}

PrimitiveFollower::PrimitiveFollower(const MotionPrimitive& primitive, const WheelLimits& limits,
                                     const WheelDisplacement& travelled)
    : primitive_(driveable(primitive, limits.wheel_separation_m)),
      limits_(limits),
      part_start_(travelled) {
  if (primitive_.turn_rad == 0.0) nextPart(travelled);
}

double PrimitiveFollower::targetOfPart() const {
  return part_ == Part::kTurning ? turningWheels(primitive_, limits_.wheel_separation_m).right_m
                                 : primitive_.length_m;
}

/// What the part asks of the right wheel, taken over both wheels.
double PrimitiveFollower::progressOfPart(const WheelDisplacement& travelled) const {
  const double left_m = travelled.left_m - part_start_.left_m;
  const double right_m = travelled.right_m - part_start_.right_m;
  return 0.5 * (part_ == Part::kTurning ? right_m - left_m : right_m + left_m);
}

void PrimitiveFollower::nextPart(const WheelDisplacement& travelled) {
  part_ = part_ == Part::kTurning ? Part::kStraight : Part::kDone;
  part_start_ = travelled;
  part_time_s_ = 0.0;
  if (part_ == Part::kStraight && primitive_.length_m == 0.0) part_ = Part::kDone;
}

MotionPrimitive PrimitiveFollower::remaining(const WheelDisplacement& travelled) const {
  const double left_m = targetOfPart() - progressOfPart(travelled);
  switch (part_) {
    case Part::kTurning:
      return {2.0 * left_m / limits_.wheel_separation_m, primitive_.length_m};
    case Part::kStraight:
      return {0.0, left_m};
    case Part::kDone:
      break;
  }
  return {};
}

bool PrimitiveFollower::isDisobeyed(const WheelDisplacement& travelled) const {
  if (part_ == Part::kDone) return false;
  const double target_m = targetOfPart();
  const double progress_m = std::copysign(1.0, target_m) * progressOfPart(travelled);
  const double patience_s = kPatienceFactor * travelTime(target_m, limits_) + kPatience_s;
  return progress_m < -kPatience_m || progress_m > std::abs(target_m) + kPatience_m ||
         part_time_s_ > patience_s;
}

WheelSpeeds PrimitiveFollower::steer(const WheelDisplacement& travelled, const WheelSpeeds& before,
                                     double period_s) {
  if (is_abandoned_) {
    const WheelSpeeds slower = braked(before, limits_, period_s);
    if (isStanding(slower)) part_ = Part::kDone;
    return slower;
  }
  if (part_ == Part::kDone) return braked(before, limits_, period_s);
  part_time_s_ += period_s;
  const double left_m = targetOfPart() - progressOfPart(travelled) - before.right_mps * period_s;
  const double sense = std::copysign(1.0, targetOfPart());
  const double ahead_m = sense * left_m;
  const double braking = kBrakingShare * limits_.max_acceleration_mps2;
  const double wanted = ahead_m <= kArrived_m
                            ? 0.0
                            : std::min(limits_.max_speed_mps, std::sqrt(2.0 * braking * ahead_m));
  const double speed =
      approach(before.right_mps, sense * wanted, limits_.max_acceleration_mps2 * period_s);
  const WheelSpeeds next{part_ == Part::kTurning ? -speed : speed, speed};
  if (wanted <= 0.0 && speed == 0.0) nextPart(travelled);
  return next;
}

}  // namespace bearing_calibration::core
