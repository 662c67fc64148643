#include "bearing_calibration/calibration/sight_change.h"

#include <cmath>
#include <cstddef>

#include "bearing_calibration/geometry/pose2.h"

namespace bearing_calibration {
namespace {

/// A part of an arc, from its start.
Pose2 partOfArc(const Pose2& arc, double fraction) {
  // The chord of an arc that turns by a is d sinc(a/2); that of its part follows from it.
  constexpr double kAlmostStraight_rad = 1e-6;
  const double turn = arc.yaw_rad;
  const double part = fraction * turn;
  const double ratio =
      std::abs(turn) < kAlmostStraight_rad ? fraction : std::sin(0.5 * part) / std::sin(0.5 * turn);
  return {rotation2(0.5 * (part - turn)) * arc.position_m * ratio, part};
}

/// What the wheels rolled on the arc (left [m], right [m]).
Eigen::Vector2d wheelsFromArc(const Pose2& arc, double wheel_separation_m) {
  constexpr double kAlmostStraight_rad = 1e-6;
  const double half_turn = 0.5 * arc.yaw_rad;
  const double chord =
      arc.position_m.dot(Eigen::Vector2d(std::cos(half_turn), std::sin(half_turn)));
  const double distance =
      std::abs(half_turn) < kAlmostStraight_rad ? chord : chord * half_turn / std::sin(half_turn);
  return {distance - half_turn * wheel_separation_m, distance + half_turn * wheel_separation_m};
}

}  // namespace

std::vector<Sight> withOtherWheels(const std::vector<Sight>& sights,
                                   const Eigen::Matrix2d& wheels_from_wheels,
                                   double believed_separation_m, double changed_separation_m) {
  std::vector<Sight> changed = sights;
  for (Sight& sight : changed) {
    const Eigen::Vector2d wheels =
        wheels_from_wheels * wheelsFromArc(sight.motion.start_from_end, believed_separation_m);
    sight.motion.start_from_end =
        arcFromWheels({wheels.x(), wheels.y()}, changed_separation_m).start_from_end;
    sight.motion.distance_m = 0.5 * std::abs(wheels.sum());
    sight.motion.rotation_rad = std::abs(wheels.y() - wheels.x()) / changed_separation_m;
  }
  return changed;
}

std::vector<Sight> withEarlierBearings(const std::vector<Sight>& sights, double earlier_s) {
  std::vector<Pose2> first_from_base(1);
  for (std::size_t i = 1; i < sights.size(); ++i) {
    first_from_base.push_back(first_from_base.back() * sights[i].motion.start_from_end);
  }
  const Duration earlier = durationFromSeconds(earlier_s);
  std::vector<Sight> changed;
  Pose2 last;
  std::size_t after = 1;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Stamp moment = sights[i].stamp - earlier;
    if (moment < sights.front().stamp || moment > sights.back().stamp) continue;
    while (after + 1 < sights.size() && sights[after].stamp < moment) ++after;
    while (after > 1 && sights[after - 1].stamp > moment) --after;
    const double interval_s = secondsFromDuration(sights[after].stamp - sights[after - 1].stamp);
    const double fraction = secondsFromDuration(moment - sights[after - 1].stamp) / interval_s;
    const Pose2 pose =
        first_from_base[after - 1] * partOfArc(sights[after].motion.start_from_end, fraction);
    Sight sight = sights[i];
    sight.motion.start_from_end = last.inverse() * pose;
    last = pose;
    changed.push_back(sight);
  }
  return changed;
}

}  // namespace bearing_calibration
