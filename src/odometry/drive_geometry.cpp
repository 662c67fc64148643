#include "bearing_calibration/odometry/drive_geometry.h"

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration {

double DriveGeometry::leftMetersPerTick() const {
  return 2.0 * kPi * left_wheel_radius_m / ticks_per_revolution;
}

double DriveGeometry::rightMetersPerTick() const {
  return 2.0 * kPi * right_wheel_radius_m / ticks_per_revolution;
}

std::vector<std::string> DriveGeometry::validate() const {
  Requirements require;
  require.positive("wheels/separation", wheel_separation_m);
  require.positive("wheels/left_radius", left_wheel_radius_m);
  require.positive("wheels/right_radius", right_wheel_radius_m);
  require.positive("wheels/ticks_per_revolution", ticks_per_revolution);
  require.positive("wheels/max_speed", max_wheel_speed_mps);
  require.that(
      counter_bits == 8 || counter_bits == 16 || counter_bits == 32 || counter_bits == 64,
      "wheels/counter_bits must be 8, 16, 32 or 64, but is " + std::to_string(counter_bits));
  return require.errors();
}

std::vector<std::string> WheelNoise::validate() const {
  Requirements require;
  require.notNegative("wheels/noise_independent", independent_k_m);
  require.notNegative("wheels/noise_common", common_k_m);
  require.that(independent_k_m + common_k_m > 0.0,
               "wheels/noise_independent and wheels/noise_common must not both be 0");
  return require.errors();
}

}  // namespace bearing_calibration
