#include "bearing_calibration/odometry/drive_geometry.h"

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {

std::vector<std::string> DriveGeometry::validate() const {
  constexpr double kWidestRobot_m = 100.0;
  constexpr double kLargestWheel_m = 10.0;
  constexpr double kFewestTicks = 0.1;  // a magnet behind a gear
  constexpr double kMostTicks = 1e9;    // 23 bits behind a gear of 100
  Requirements require;
  require.between("wheels/separation", wheel_separation_m, plausible::kShortest_m, kWidestRobot_m);
  require.between("wheels/left_radius", left_wheel_radius_m, plausible::kShortest_m,
                  kLargestWheel_m);
  require.between("wheels/right_radius", right_wheel_radius_m, plausible::kShortest_m,
                  kLargestWheel_m);
  require.between("wheels/ticks_per_revolution", ticks_per_revolution, kFewestTicks, kMostTicks);
  require.between("wheels/max_speed", max_wheel_speed_mps, plausible::kSlowest_mps,
                  plausible::kFastest_mps);
  require.that(
      counter_bits == 8 || counter_bits == 16 || counter_bits == 32 || counter_bits == 64,
      "wheels/counter_bits must be 8, 16, 32 or 64, but is " + std::to_string(counter_bits));
  return require.errors();
}

std::vector<std::string> WheelNoise::validate() const {
  constexpr double kNoisiest_m = 1.0;  // a metre off after a metre
  Requirements require;
  require.between("wheels/noise_independent", independent_k_m, 0.0, kNoisiest_m);
  require.between("wheels/noise_common", common_k_m, 0.0, kNoisiest_m);
  require.that(independent_k_m + common_k_m > 0.0,
               "wheels/noise_independent and wheels/noise_common must not both be 0");
  return require.errors();
}

}  // namespace bearing_calibration::core
