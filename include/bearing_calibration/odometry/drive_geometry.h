#pragma once

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// The wheels of a differential drive and their encoders.
struct DriveGeometry {
  double wheel_separation_m = 0.0;  ///< distance between the wheels' contact points
  double left_wheel_radius_m = 0.0;
  double right_wheel_radius_m = 0.0;
  double ticks_per_revolution = 0.0;  ///< of the wheel, after the gear
  int counter_bits = 0;               ///< width at which the counters wrap: 8, 16, 32 or 64
  double max_wheel_speed_mps = 0.0;   ///< fastest possible; what exceeds it is not motion

  double metersPerTick(double radius_m) const {
    return 2.0 * kPi * radius_m / ticks_per_revolution;
  }
  double leftMetersPerTick() const { return metersPerTick(left_wheel_radius_m); }
  double rightMetersPerTick() const { return metersPerTick(right_wheel_radius_m); }

  void declare(Parameters& params);
};

/// Random errors of the wheels' displacements, growing with the distance that each has rolled.
struct WheelNoise {
  /// K of Chong and Kleeman [m]: the variance of one wheel's displacement is K |displacement|,
  /// independent for left and right (paper, eq. 22).
  double independent_k_m = 0.0;
  /// The same for an error that both wheels share (a slip along the way, a soft floor) [m]: the
  /// variance of the displacement of the base's centre grows by this times the distance.
  double common_k_m = 0.0;

  void declare(Parameters& params);
  /// The same of a simulated robot, whose wheels may be exact.
  void declareLevels(Parameters& params);
};

/// How long the wheels' readings are waited for and kept.
struct WheelTimes {
  double max_apart_s = 0.0;  ///< see WheelPairing; only for wheels that come one by one
  double history_s = 0.0;    ///< travel is remembered so long for bearings that arrive late

  void declare(Parameters& params);
};

}  // namespace bearing_calibration::core
