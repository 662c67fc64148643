#pragma once

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/odometry_increment.h"

namespace bearing_calibration::core {

/// What the wheels may do. Parameter group `limits`.
struct WheelLimits {
  double wheel_separation_m = 0.0;
  double max_speed_mps = 0.0;  ///< of each wheel
  double max_acceleration_mps2 = 0.0;

  void declare(Parameters& params);
};

/// The motion primitive of a differential drive: turn on the spot, then go straight, from
/// standstill to standstill. Both parts may be empty. Backwards is a negative length.
struct MotionPrimitive {
  double turn_rad = 0.0;  ///< counter-clockwise, by any number of full turns
  double length_m = 0.0;
};

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

}  // namespace bearing_calibration::core
