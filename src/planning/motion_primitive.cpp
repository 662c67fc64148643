#include "bearing_calibration/planning/motion_primitive.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

void WheelLimits::declare(Parameters& params) {
  constexpr double kSlowest_mps2 = 1e-4;
  constexpr double kFastest_mps2 = 1000.0;
  params.positive("wheels/separation", wheel_separation_m);
  params.number("limits/wheel_speed", max_speed_mps, plausible::kSlowest_mps,
                plausible::kFastest_mps);
  params.number("limits/wheel_acceleration", max_acceleration_mps2, kSlowest_mps2, kFastest_mps2);
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
  const double ramp_s =
      std::min(0.5 * whole_s, limits.max_speed_mps / limits.max_acceleration_mps2);
  const double half_a = 0.5 * limits.max_acceleration_mps2;
  const double time = std::clamp(time_s, 0.0, whole_s);
  const double way_m = std::abs(distance_m);
  double travel_m = half_a * ramp_s * ramp_s + 2.0 * half_a * ramp_s * (time - ramp_s);
  if (time < ramp_s) travel_m = half_a * time * time;
  if (time > whole_s - ramp_s) travel_m = way_m - half_a * (whole_s - time) * (whole_s - time);
  return std::copysign(travel_m, distance_m);
}

double durationOf(const MotionPrimitive& primitive, const WheelLimits& limits) {
  return travelTime(turningWheels(primitive, limits.wheel_separation_m).right_m, limits) +
         travelTime(primitive.length_m, limits);
}

}  // namespace bearing_calibration::core
