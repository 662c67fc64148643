#include "bearing_calibration/calibration/config.h"

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/lights_state.h"

namespace bearing_calibration {

std::vector<std::string> BearingInputConfig::validate() const {
  constexpr double kLongestLatency_s = 10.0;
  Requirements require;
  require.between("bearings/latency", latency_s, -kLongestLatency_s, kLongestLatency_s);
  require.notNegative("bearings/extra_stddev", extra_stddev_rad);
  require.positive("bearings/min_stddev", min_stddev_rad);
  require.that(max_stddev_rad > min_stddev_rad,
               "bearings/max_stddev must be greater than bearings/min_stddev");
  require.notNegative("bearings/max_future", max_future_s);
  require.notNegative("bearings/reorder_window", reorder_window_s);
  require.positive("bearings/max_waiting", max_waiting);
  require.between("bearings/min_quality", min_quality, 0.0, 1.0);
  return require.errors();
}

std::vector<std::string> StartConfig::validate() const {
  Requirements require;
  if (kind == Kind::kNothing) return require.errors();
  constexpr double kFarthest_m = 1000.0;
  require.positive("start/light_distance", light_distance_m);
  require.positive("start/light_distance_stddev", light_distance_stddev_m);
  require.between("start/x", x_m, -kFarthest_m, kFarthest_m);
  require.between("start/y", y_m, -kFarthest_m, kFarthest_m);
  require.positive("start/position_stddev", position_stddev_m);
  require.between("start/yaw", yaw_rad, -2.0 * kPi, 2.0 * kPi);
  require.positive("start/yaw_stddev", yaw_stddev_rad);
  return require.errors();
}

std::vector<std::string> FilterConfig::validate() const {
  constexpr double kSmallestGate = 0.5;
  constexpr double kLargestGate = 1.0 - 1e-12;
  Requirements require;
  require.between("filter/gate_probability", gate_probability, kSmallestGate, kLargestGate);
  require.positive("filter/recovery_after", recovery_after);
  require.notNegative("filter/recovery_bearing_stddev", recovery_bearing_stddev_rad);
  require.notNegative("filter/recovery_distance_stddev", recovery_distance_stddev_m);
  return require.errors();
}

std::vector<std::string> ConvergenceConfig::validate() const {
  Requirements require;
  require.positive("converged/position_stddev", position_stddev_m);
  require.positive("converged/yaw_stddev", yaw_stddev_rad);
  return require.errors();
}

std::vector<std::string> LightsConfig::validate() const {
  Requirements require;
  require.that(most >= 1 && most <= kMostLights, "lights/most must be 1 to " +
                                                     std::to_string(kMostLights) + ", but is " +
                                                     std::to_string(most));
  return require.errors();
}

std::vector<std::string> CalibratorConfig::validate() const {
  Requirements require;
  require.add(drive.validate());
  require.add(wheel_noise.validate());
  require.positive("wheels/max_apart", max_wheels_apart_s);
  require.positive("wheels/history", tick_history_s);
  require.add(bearings.validate());
  require.add(start.validate());
  require.add(initializer.validate());
  require.add(filter.validate());
  require.add(converged.validate());
  require.add(lights.validate());
  require.that(
      lights.most == 1 || !initializer.batch.errors.usesElevations(),
      "errors/sensor_tilt_stddev needs lights/most 1: it looks for the height of one light");
  require.notNegative("refit_growth", refit_growth);
  return require.errors();
}

}  // namespace bearing_calibration
