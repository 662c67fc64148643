#include "bearing_calibration/odometry/drive_geometry.h"

namespace bearing_calibration::core {

void DriveGeometry::declare(Parameters& params) {
  using namespace plausible;
  constexpr double kWidestRobot_m = 100.0;
  constexpr double kLargestWheel_m = 10.0;
  constexpr double kFewestTicks = 0.1;  // a magnet behind a gear
  constexpr double kMostTicks = 1e9;    // 23 bits behind a gear of 100
  params.number("wheels/separation", wheel_separation_m, kShortest_m, kWidestRobot_m);
  params.number("wheels/left_radius", left_wheel_radius_m, kShortest_m, kLargestWheel_m);
  params.number("wheels/right_radius", right_wheel_radius_m, kShortest_m, kLargestWheel_m);
  params.number("wheels/ticks_per_revolution", ticks_per_revolution, kFewestTicks, kMostTicks);
  params.number("wheels/max_speed", max_wheel_speed_mps, kSlowest_mps, kFastest_mps);
  params.read("wheels/counter_bits", counter_bits);
  params.that(
      counter_bits == 8 || counter_bits == 16 || counter_bits == 32 || counter_bits == 64,
      "wheels/counter_bits must be 8, 16, 32 or 64, but is " + std::to_string(counter_bits));
}

void WheelNoise::declare(Parameters& params) {
  declareLevels(params);
  params.that(independent_k_m + common_k_m > 0.0,
              "wheels/noise_independent and wheels/noise_common must not both be 0");
}

void WheelNoise::declareLevels(Parameters& params) {
  constexpr double kNoisiest_m = 1.0;  // a metre off after a metre
  params.number("wheels/noise_independent", independent_k_m, 0.0, kNoisiest_m);
  params.number("wheels/noise_common", common_k_m, 0.0, kNoisiest_m);
}

void WheelTimes::declare(Parameters& params) {
  using namespace plausible;
  params.number("wheels/max_apart", max_apart_s, kBriefest_s, kLongestHistory_s);
  params.number("wheels/history", history_s, kBriefest_s, kLongestHistory_s);
}

}  // namespace bearing_calibration::core
