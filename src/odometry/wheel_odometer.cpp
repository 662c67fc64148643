#include "bearing_calibration/odometry/wheel_odometer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bearing_calibration::core {
namespace {

constexpr double kReadingSlackTicks = 2.0;  // one of quantisation at each end
constexpr double kStampJitter_s = 0.01;     // drivers stamp on receipt

double largest(const WheelDisplacement& wheels) {
  return std::max(std::abs(wheels.left_m), std::abs(wheels.right_m));
}

}  // namespace

void JointRange::add(double position_rad) {
  least_rad_ = std::min(least_rad_, position_rad);
  most_rad_ = std::max(most_rad_, position_rad);
}

double JointRange::turn(double from_rad, double to_rad) const {
  constexpr double kRounding_rad = 1e-3;  // of drivers that count in floats
  const double range_rad = std::max(most_rad_, to_rad) - std::min(least_rad_, to_rad);
  const double turn_rad = to_rad - from_rad;
  return range_rad < 2.0 * kPi + kRounding_rad ? wrapAngle(turn_rad) : turn_rad;
}

InputOutcome WheelOdometer::add(const WheelCounts& ticks) {
  for (std::int64_t count : {ticks.left_ticks, ticks.right_ticks}) {
    if (!fitsCounter(count, geometry_.counter_bits)) {
      return {InputStatus::kTicksOutOfRange, static_cast<double>(count)};
    }
  }
  return addReading({ticks, {}, ticks.stamp});
}

InputOutcome WheelOdometer::add(const WheelAngles& angles) {
  for (double angle : {angles.left_rad, angles.right_rad}) {
    if (!std::isfinite(angle)) return {InputStatus::kAngleNotFinite, angle};
  }
  return addReading({{}, angles, angles.stamp});
}

InputOutcome WheelOdometer::addReading(const Reading& reading) {
  if (!isStamped(reading.stamp)) return {InputStatus::kNoStamp, 0.0};
  if (!travel_) {
    travel_ = WheelTravel{reading.stamp, 0.0, 0.0, 0.0};
    moveTo(reading, {});
    return {};
  }
  if (reading.stamp <= travel_->stamp) {
    noteLate(reading.stamp);
    return {InputStatus::kStampNotAfterLast, secondsFromDuration(travel_->stamp - reading.stamp)};
  }
  const WheelDisplacement wheels = displacement(last_, reading);
  const double interval_s = timeBetween(last_, reading);
  if (geometry_.max_wheel_speed_mps * interval_s > farthestCertain(last_, reading)) {
    moveUnseenTo(reading);
    return {InputStatus::kTicksGap, interval_s};
  }
  if (largest(wheels) <= reach(last_, reading)) {
    moveTo(reading, wheels);
    return {};
  }
  return resolveJump(reading, largest(wheels));
}

void WheelOdometer::noteLate(Stamp stamp) {
  if (!travel_) return;
  const bool follows = late_ && stamp > late_->last;
  late_ = follows ? LateRow{late_->first, stamp, late_->count + 1} : LateRow{stamp, stamp, 1};
}

InputOutcome WheelOdometer::resolveJump(const Reading& reading, double jump_m) {
  const Reading zero{{}, {}, last_.stamp};
  const bool restarted = largest(displacement(zero, reading)) <= reach(zero, reading);
  const bool confirmed = refused_ && refused_->stamp < reading.stamp &&
                         largest(displacement(*refused_, reading)) <= reach(*refused_, reading);
  if (restarted || confirmed) {
    moveUnseenTo(reading);
    return {InputStatus::kCounterReset, jump_m};
  }
  refused_ = reading;
  return {InputStatus::kTicksTooFast, jump_m};
}

WheelDisplacement WheelOdometer::displacement(const Reading& from, const Reading& to) const {
  const int bits = geometry_.counter_bits;
  const auto left_ticks = wrappedTickDifference(from.ticks.left_ticks, to.ticks.left_ticks, bits);
  const auto right_ticks =
      wrappedTickDifference(from.ticks.right_ticks, to.ticks.right_ticks, bits);
  return {static_cast<double>(left_ticks) * geometry_.leftMetersPerTick() +
              left_joint_.turn(from.angles.left_rad, to.angles.left_rad) *
                  geometry_.left_wheel_radius_m,
          static_cast<double>(right_ticks) * geometry_.rightMetersPerTick() +
              right_joint_.turn(from.angles.right_rad, to.angles.right_rad) *
                  geometry_.right_wheel_radius_m};
}

double WheelOdometer::farthestCertain(const Reading& from, const Reading& to) const {
  if (isStamped(to.ticks.stamp)) {
    return std::ldexp(0.5, geometry_.counter_bits) *
           std::min(geometry_.leftMetersPerTick(), geometry_.rightMetersPerTick());
  }
  // A joint that is taken the shorter way round has wrapped, or turned by more than a half.
  const auto certain_m = [](const JointRange& joint, double from_rad, double to_rad,
                            double radius_m) {
    const bool seems_to_wrap = joint.turn(from_rad, to_rad) != to_rad - from_rad;
    return seems_to_wrap ? kPi * radius_m : std::numeric_limits<double>::infinity();
  };
  return std::min(certain_m(left_joint_, from.angles.left_rad, to.angles.left_rad,
                            geometry_.left_wheel_radius_m),
                  certain_m(right_joint_, from.angles.right_rad, to.angles.right_rad,
                            geometry_.right_wheel_radius_m));
}

double WheelOdometer::timeBetween(const Reading& from, const Reading& to) const {
  const double stamped_s = secondsFromDuration(to.stamp - from.stamp);
  if (!isSteppedBack()) return stamped_s;
  // The late readings, and the two around them, are one period apart.
  const double period_s = secondsFromDuration(late_->last - late_->first) / (late_->count - 1);
  return stamped_s + (late_->count + 1) * period_s;
}

double WheelOdometer::reach(const Reading& from, const Reading& to) const {
  return geometry_.max_wheel_speed_mps * (timeBetween(from, to) + kStampJitter_s) +
         kReadingSlackTicks *
             std::max(geometry_.leftMetersPerTick(), geometry_.rightMetersPerTick());
}

void WheelOdometer::moveTo(const Reading& reading, const WheelDisplacement& wheels) {
  travel_->stamp = reading.stamp;
  travel_->left_m += wheels.left_m;
  travel_->right_m += wheels.right_m;
  left_joint_.add(reading.angles.left_rad);
  right_joint_.add(reading.angles.right_rad);
  last_ = reading;
  refused_.reset();
  late_.reset();
}

void WheelOdometer::moveUnseenTo(const Reading& reading) {
  constexpr double kUniformVariance = 1.0 / 3.0;  // of a uniform distribution on [-1, 1]
  const double reach_m = reach(last_, reading);
  travel_->unseen_variance_m2 += kUniformVariance * reach_m * reach_m;
  moveTo(reading, {});
}

}  // namespace bearing_calibration::core
