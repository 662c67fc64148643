#include "bearing_calibration/planning/motion_primitive.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/linestring.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/geometries/segment.hpp>
#include <cmath>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

/// Share of the acceleration that braking for the end plans with: wheels answer late.
constexpr double kBrakingShare = 0.7;
/// A wheel may lag behind or roll back so far [m] before it is said to disobey.
constexpr double kPatience_m = 0.1;
/// ... or a part, or any motion of a wheel, may take so many times its duration, and so much longer
/// [s].
constexpr double kPatienceFactor = 3.0;
constexpr double kPatience_s = 3.0;
/// Wheels that do not move for so long, so near to the end, are too stiff for so slow a command.
constexpr double kStiff_s = 0.5;
constexpr double kStiff_m = 0.02;

double longestTime(double way_m, double delay_s, const WheelLimits& limits) {
  return kPatienceFactor * travelTime(way_m, limits) + delay_s;
}

namespace geometry = boost::geometry;
using Point = geometry::model::d2::point_xy<double>;
using Polygon = geometry::model::polygon<Point>;
using Line = geometry::model::linestring<Point>;

/// Clearance of a way that leaves the region past an inward corner, between ends that lie inside.
constexpr double kOutsideBetween_m = 1e-9;

Point pointFrom(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

Polygon polygonFrom(const std::vector<Eigen::Vector2d>& corners) {
  Polygon polygon;
  for (const Eigen::Vector2d& corner : corners) geometry::append(polygon, pointFrom(corner));
  geometry::correct(polygon);  // closed, and in the order that the library wants
  return polygon;
}

}  // namespace

void WheelLimits::declare(Parameters& params) {
  constexpr double kSlowest_mps2 = 1e-4;
  constexpr double kFastest_mps2 = 1000.0;
  params.between("wheels/separation", wheel_separation_m, plausible::kShortest_m,
                 plausible::kFarthest_m);
  params.number("limits/wheel_speed", max_speed_mps, plausible::kSlowest_mps,
                plausible::kFastest_mps);
  params.number("limits/wheel_acceleration", max_acceleration_mps2, kSlowest_mps2, kFastest_mps2);
}

void Region::declare(Parameters& params) {
  constexpr std::size_t kLeastCorners = 3;
  params.list("region/polygon", 2, polygon_m,
              [](const auto& row) { return Eigen::Vector2d(row[0], row[1]); });
  params.number("region/radius", radius_m, 0.0, plausible::kFarthest_m);
  params.that(!polygon_m.empty() || radius_m >= plausible::kShortest_m,
              formatted("region/radius must be at least %g without region/polygon",
                        plausible::kShortest_m));
  if (polygon_m.empty()) return;
  const bool is_near =
      std::all_of(polygon_m.begin(), polygon_m.end(), [](const Eigen::Vector2d& corner) {
        return corner.cwiseAbs().maxCoeff() <= plausible::kFarthest_m;
      });
  params.that(is_near, "region/polygon must lie within 1000 m of the start");
  params.that(
      polygon_m.size() >= kLeastCorners,
      "region/polygon must have at least 3 corners, but has " + std::to_string(polygon_m.size()));
  if (!is_near || polygon_m.size() < kLeastCorners) return;
  params.that(geometry::is_valid(polygonFrom(polygon_m)), "region/polygon must not cross itself");
  params.that(clearance(Eigen::Vector2d::Zero()) > 0.0,
              "region/polygon must contain the start, (0, 0)");
}

double Region::clearance(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  if (polygon_m.empty()) return radius_m - std::max(from.norm(), to.norm());
  const Polygon polygon = polygonFrom(polygon_m);
  const geometry::model::segment<Point> way(pointFrom(from), pointFrom(to));
  const Line border(polygon.outer().begin(), polygon.outer().end());
  const auto to_border = [&border](const auto& what) { return geometry::distance(what, border); };
  if (!geometry::within(pointFrom(from), polygon)) return -to_border(pointFrom(from));
  if (!geometry::within(pointFrom(to), polygon)) return -to_border(pointFrom(to));
  const double clearance_m = to_border(way);
  return clearance_m > 0.0 ? clearance_m : -kOutsideBetween_m;
}

Pose2 poseAfter(const MotionPrimitive& primitive, const Pose2& frame_from_base) {
  const Pose2 turned{frame_from_base.position_m,
                     wrapAngle(frame_from_base.yaw_rad + primitive.turn_rad)};
  return turned * Pose2{{primitive.length_m, 0.0}, 0.0};
}

WheelDisplacement turningWheels(const MotionPrimitive& primitive, double wheel_separation_m) {
  const double way_m = 0.5 * wheel_separation_m * primitive.turn_rad;
  return {-way_m, way_m};
}

WheelDisplacement straightWheels(const MotionPrimitive& primitive) {
  return {primitive.length_m, primitive.length_m};
}

MotionPrimitive driveable(const MotionPrimitive& primitive, double wheel_separation_m) {
  const double turning_m = turningWheels(primitive, wheel_separation_m).right_m;
  return {std::abs(turning_m) > kArrived_m ? primitive.turn_rad : 0.0,
          std::abs(primitive.length_m) > kArrived_m ? primitive.length_m : 0.0};
}

double travelTime(double distance_m, const WheelLimits& limits) {
  const double way_m = std::abs(distance_m);
  const double ramps_m = limits.max_speed_mps * limits.max_speed_mps / limits.max_acceleration_mps2;
  if (way_m < ramps_m) return 2.0 * std::sqrt(way_m / limits.max_acceleration_mps2);
  return way_m / limits.max_speed_mps + limits.max_speed_mps / limits.max_acceleration_mps2;
}

double travelAt(double time_s, double distance_m, const WheelLimits& limits) {
  const double whole_s = travelTime(distance_m, limits);
  const double time = std::clamp(time_s, 0.0, whole_s);
  if (time > 0.5 * whole_s) return distance_m - travelAt(whole_s - time, distance_m, limits);
  const double ramp_s = std::min(time, limits.max_speed_mps / limits.max_acceleration_mps2);
  const double travel_m =
      0.5 * limits.max_acceleration_mps2 * ramp_s * ramp_s + limits.max_speed_mps * (time - ramp_s);
  return std::copysign(travel_m, distance_m);
}

double durationOf(const MotionPrimitive& primitive, const WheelLimits& limits) {
  return travelTime(turningWheels(primitive, limits.wheel_separation_m).right_m, limits) +
         travelTime(primitive.length_m, limits);
}

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
      part_start_(travelled),
      last_moved_(travelled) {
  if (primitive_.turn_rad == 0.0) nextPart(travelled);
}

/// Of the right wheel.
double PrimitiveFollower::targetOfPart() const {
  return part_ == Part::kTurning ? turningWheels(primitive_, limits_.wheel_separation_m).right_m
                                 : primitive_.length_m;
}

/// What is left of it, taken over both wheels.
double PrimitiveFollower::leftOfPart(const WheelDisplacement& travelled) const {
  const double left_m = travelled.left_m - part_start_.left_m;
  const double right_m = travelled.right_m - part_start_.right_m;
  return targetOfPart() - 0.5 * (part_ == Part::kTurning ? right_m - left_m : right_m + left_m);
}

void PrimitiveFollower::nextPart(const WheelDisplacement& travelled) {
  const bool has_straight = part_ == Part::kTurning && primitive_.length_m != 0.0;
  part_ = has_straight ? Part::kStraight : Part::kDone;
  part_start_ = last_moved_ = travelled;
  part_time_s_ = still_s_ = 0.0;
}

MotionPrimitive PrimitiveFollower::remaining(const WheelDisplacement& travelled) const {
  if (done()) return {};
  const double left_m = leftOfPart(travelled);
  if (part_ == Part::kStraight) return {0.0, left_m};
  return {2.0 * left_m / limits_.wheel_separation_m, primitive_.length_m};
}

bool PrimitiveFollower::isDisobeyed(const WheelDisplacement& travelled) const {
  if (done()) return false;
  const double target_m = targetOfPart();
  const double ahead_m = std::copysign(1.0, target_m) * leftOfPart(travelled);
  return ahead_m < -kPatience_m || ahead_m > std::abs(target_m) + kPatience_m ||
         part_time_s_ > longestTime(target_m, kPatience_s, limits_) ||
         still_s_ > longestTime(kArrived_m, kPatience_s, limits_);
}

WheelSpeeds PrimitiveFollower::steer(const WheelDisplacement& travelled, const WheelSpeeds& before,
                                     double period_s) {
  if (is_abandoned_ || done()) {
    const WheelSpeeds slower = braked(before, limits_, period_s);
    if (isStanding(slower)) part_ = Part::kDone;
    return slower;
  }
  part_time_s_ += period_s;
  still_s_ += period_s;
  if (std::min(std::abs(travelled.left_m - last_moved_.left_m),
               std::abs(travelled.right_m - last_moved_.right_m)) > kArrived_m) {
    last_moved_ = travelled;
    still_s_ = 0.0;
  }
  const double sense = std::copysign(1.0, targetOfPart());
  const double ahead_m = sense * (leftOfPart(travelled) - before.right_mps * period_s);
  const double braking = kBrakingShare * limits_.max_acceleration_mps2;
  const bool is_stiff = still_s_ > longestTime(kArrived_m, kStiff_s, limits_);
  const bool has_arrived = ahead_m <= (is_stiff ? kStiff_m : kArrived_m);
  const double wanted =
      has_arrived ? 0.0 : std::min(limits_.max_speed_mps, std::sqrt(2.0 * braking * ahead_m));
  constexpr double kLongestPeriod_s = 0.1;  // a late command brakes for all of its time only
  const bool is_faster = wanted > std::abs(before.right_mps);
  const double most =
      limits_.max_acceleration_mps2 * (is_faster ? std::min(period_s, kLongestPeriod_s) : period_s);
  const double speed =
      before.right_mps + std::clamp(sense * wanted - before.right_mps, -most, most);
  const WheelSpeeds next{part_ == Part::kTurning ? -speed : speed, speed};
  if (wanted <= 0.0 && speed == 0.0) nextPart(travelled);
  return next;
}

}  // namespace bearing_calibration::core
