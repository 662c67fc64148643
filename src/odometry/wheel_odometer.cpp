#include "bearing_calibration/odometry/wheel_odometer.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bearing_calibration::core {
namespace {

constexpr double kReadingSlackTicks = 2.0;  // one of quantisation at each end
constexpr double kPoseSlack_m = 0.002;      // of drivers that send whole millimetres
constexpr double kStampJitter_s = 0.01;     // drivers stamp on receipt
constexpr double kMostSideways_m = 0.005;   // of such a driver's rounding; wheels make none

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
  return addReading({ticks, {}, {}, ticks.stamp});
}

InputOutcome WheelOdometer::add(const WheelAngles& angles) {
  for (double angle : {angles.left_rad, angles.right_rad}) {
    if (!std::isfinite(angle)) return {InputStatus::kAngleNotFinite, angle};
  }
  return addReading({{}, angles, {}, angles.stamp});
}

InputOutcome WheelOdometer::add(const OdometryPose& odometry) {
  constexpr double kNearOne = 0.01;  // of drivers that round
  const Pose2& pose = odometry.start_from_base;
  for (double number : {pose.position_m.x(), pose.position_m.y(), pose.yaw_rad}) {
    if (!std::isfinite(number)) return {InputStatus::kPoseNotFinite, number};
  }
  if (!(std::abs(odometry.quaternion_norm - 1.0) <= kNearOne)) {
    return {InputStatus::kQuaternionNotUnit, odometry.quaternion_norm};
  }
  if (!frames_) frames_ = odometry.frames;
  if (*frames_ != odometry.frames) return {InputStatus::kFramesChanged, 0.0};
  if (standsAgainstItsTwist(odometry)) return {InputStatus::kTwistWithoutPose, twist_travel_m_};
  return addReading({{}, {}, pose, odometry.stamp, true});
}

bool WheelOdometer::standsAgainstItsTwist(const OdometryPose& odometry) {
  constexpr double kMostTravel_m = 0.2;  // what a filtered or a commanded twist says of a stop
  constexpr double kStill_mps = 0.02;    // what a gyroscope's bias and noise say of standing
  const Pose2& last = last_.start_from_base;
  const bool stands = travel_ && odometry.start_from_base.position_m == last.position_m &&
                      odometry.start_from_base.yaw_rad == last.yaw_rad;
  const double speed_mps = std::abs(odometry.forward_mps) +
                           0.5 * geometry_.wheel_separation_m * std::abs(odometry.turn_radps);
  if (!stands) {
    twist_travel_m_ = 0.0;
  } else if (odometry.stamp > last_twist_ && std::isfinite(speed_mps) && speed_mps > kStill_mps) {
    twist_travel_m_ += speed_mps * secondsFromDuration(odometry.stamp - last_twist_);
  }
  last_twist_ = std::max(last_twist_, odometry.stamp);
  return twist_travel_m_ > kMostTravel_m;
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
  if (largest(wheels) > reach(last_, reading)) {
    return resolveJump(reading, {InputStatus::kTicksTooFast, largest(wheels)});
  }
  constexpr double kForget_s = 1.0;  // rounding cancels in the sum, a slow motion sideways does not
  const double sideways_m =
      sideways_m_ * std::exp(-interval_s / kForget_s) + sidewaysStep(last_, reading);
  if (std::abs(sideways_m) > kMostSideways_m) {
    return resolveJump(reading, {InputStatus::kMovedSideways, sideways_m});
  }
  moveTo(reading, wheels);
  sideways_m_ = sideways_m;
  return {};
}

void WheelOdometer::noteLate(Stamp stamp) {
  if (!travel_) return;
  const bool follows = late_ && stamp > late_->last;
  late_ = follows ? LateRow{late_->first, stamp, late_->count + 1} : LateRow{stamp, stamp, 1};
}

InputOutcome WheelOdometer::resolveJump(const Reading& reading, const InputOutcome& refusal) {
  const Reading zero{{}, {}, {}, last_.stamp, reading.is_pose};
  const bool confirmed =
      refused_ && refused_->stamp < reading.stamp && isPossible(*refused_, reading);
  if (confirmed || isPossible(zero, reading)) {
    moveUnseenTo(reading);
    return {InputStatus::kCounterReset, std::abs(refusal.value)};
  }
  refused_ = reading;
  return refusal;
}

WheelDisplacement WheelOdometer::displacement(const Reading& from, const Reading& to) const {
  if (to.is_pose) {
    return wheelsFromArc(from.start_from_base.inverse() * to.start_from_base,
                         geometry_.wheel_separation_m);
  }
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

double WheelOdometer::sidewaysStep(const Reading& from, const Reading& to) {
  const Pose2 step = from.start_from_base.inverse() * to.start_from_base;
  const double half_turn = 0.5 * step.yaw_rad;
  const double across_m = (rotation2(-half_turn) * step.position_m).y();
  // Some drivers go by the heading at the beginning or at the end of each step.
  const double integration_m = std::sin(std::abs(half_turn)) * step.position_m.norm();
  return across_m - std::clamp(across_m, -integration_m, integration_m);
}

bool WheelOdometer::isPossible(const Reading& from, const Reading& to) const {
  return largest(displacement(from, to)) <= reach(from, to) &&
         std::abs(sidewaysStep(from, to)) <= kMostSideways_m;
}

double WheelOdometer::farthestCertain(const Reading& from, const Reading& to) const {
  if (to.is_pose) {  // the other turn to the same heading
    const double turn_rad = wrapAngle(to.start_from_base.yaw_rad - from.start_from_base.yaw_rad);
    return 0.5 * geometry_.wheel_separation_m * (2.0 * kPi - std::abs(turn_rad));
  }
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
  const double slack_m = to.is_pose ? kPoseSlack_m
                                    : kReadingSlackTicks * std::max(geometry_.leftMetersPerTick(),
                                                                    geometry_.rightMetersPerTick());
  return geometry_.max_wheel_speed_mps * (timeBetween(from, to) + kStampJitter_s) + slack_m;
}

void WheelOdometer::moveTo(const Reading& reading, const WheelDisplacement& wheels) {
  travel_->stamp = reading.stamp;
  travel_->left_m += wheels.left_m;
  travel_->right_m += wheels.right_m;
  left_joint_.add(reading.angles.left_rad);
  right_joint_.add(reading.angles.right_rad);
  last_ = reading;
  sideways_m_ = 0.0;
  refused_.reset();
  late_.reset();
}

void WheelOdometer::moveUnseenTo(const Reading& reading) {
  constexpr double kUniformVariance = 1.0 / 3.0;  // of a uniform distribution on [-1, 1]
  constexpr double kAnywhere_m = 100.0;  // in a room; after hours more would drown other variances
  const double reach_m = std::min(reach(last_, reading), kAnywhere_m);
  travel_->unseen_variance_m2 += kUniformVariance * reach_m * reach_m;
  moveTo(reading, {});
}

}  // namespace bearing_calibration::core
