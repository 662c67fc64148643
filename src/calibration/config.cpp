#include "bearing_calibration/calibration/config.h"

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/lights_state.h"

namespace bearing_calibration {

using namespace plausible;

std::vector<std::string> BearingInputConfig::validate() const {
  constexpr double kLongestLatency_s = 10.0;
  constexpr double kLongestWait_s = 60.0;
  constexpr int kMostWaiting = 100000;  // messages: some 10 MB
  Requirements require;
  require.between("bearings/latency", latency_s, -kLongestLatency_s, kLongestLatency_s);
  require.between("bearings/extra_stddev", extra_stddev_rad, 0.0, kPi);
  require.between("bearings/min_stddev", min_stddev_rad, kLeastAngle_rad, kPi);
  require.between("bearings/max_stddev", max_stddev_rad, kLeastAngle_rad, kPi);
  require.that(max_stddev_rad > min_stddev_rad,
               "bearings/max_stddev must be greater than bearings/min_stddev");
  require.between("bearings/max_future", max_future_s, 0.0, kLongest_s);
  require.between("bearings/reorder_window", reorder_window_s, 0.0, kLongestWait_s);
  require.between("bearings/max_waiting", max_waiting, 1, kMostWaiting);
  require.between("bearings/min_quality", min_quality, 0.0, 1.0);
  return require.errors();
}

std::vector<std::string> StartConfig::validate() const {
  Requirements require;
  const bool is_used = kind == Kind::kGuess;
  const double least_m = is_used ? kLeastLength_m : 0.0;
  require.between("start/light_distance", light_distance_m, least_m, kFarthest_m);
  require.between("start/light_distance_stddev", light_distance_stddev_m, least_m, kFarthest_m);
  require.between("start/x", x_m, -kFarthest_m, kFarthest_m);
  require.between("start/y", y_m, -kFarthest_m, kFarthest_m);
  require.between("start/position_stddev", position_stddev_m, least_m, kFarthest_m);
  require.between("start/yaw", yaw_rad, -kTurn_rad, kTurn_rad);
  require.between("start/yaw_stddev", yaw_stddev_rad, is_used ? kLeastAngle_rad : 0.0, kTurn_rad);
  return require.errors();
}

std::vector<std::string> FilterConfig::validate() const {
  constexpr double kSmallestGate = 0.5;
  constexpr double kLargestGate = 1.0 - 1e-12;
  Requirements require;
  require.between("filter/gate_probability", gate_probability, kSmallestGate, kLargestGate);
  require.between("filter/recovery_after", recovery_after, 1, kMostOfAKind);
  require.between("filter/recovery_bearing_stddev", recovery_bearing_stddev_rad, 0.0, kTurn_rad);
  require.between("filter/recovery_distance_stddev", recovery_distance_stddev_m, 0.0, kFarthest_m);
  return require.errors();
}

std::vector<std::string> ConvergenceConfig::validate() const {
  Requirements require;
  require.between("converged/position_stddev", position_stddev_m, kLeastLength_m, kFarthest_m);
  require.between("converged/yaw_stddev", yaw_stddev_rad, kLeastAngle_rad, kTurn_rad);
  return require.errors();
}

std::vector<std::string> LightsConfig::validate() const {
  Requirements require;
  require.between("lights/most", most, 1, kMostLights);
  return require.errors();
}

std::vector<std::string> CalibratorConfig::validate() const {
  Requirements require;
  require.add(drive.validate());
  require.add(wheel_noise.validate());
  require.between("wheels/max_apart", max_wheels_apart_s, kBriefest_s, kLongestHistory_s);
  require.between("wheels/history", tick_history_s, kBriefest_s, kLongestHistory_s);
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
