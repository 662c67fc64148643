#include "bearing_calibration/calibration/config.h"

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

using namespace plausible;

MountEstimate InitialisationConfig::mount() const {
  const double position_variance = position_stddev_m * position_stddev_m;
  MountEstimate mount;
  mount.mean << x_m, y_m, yaw_rad;
  mount.covariance.diagonal() << position_variance, position_variance,
      yaw_stddev_rad * yaw_stddev_rad;
  return mount;
}

std::vector<std::string> InitialisationConfig::validate() const {
  Requirements require;
  const bool is_used = kind == Kind::kGuess;
  const double least_m = is_used ? kLeastLength_m : 0.0;
  require.between("initialisation/light_distance", light_distance_m, least_m, kFarthest_m);
  require.between("initialisation/light_distance_stddev", light_distance_stddev_m, least_m,
                  kFarthest_m);
  require.between("initialisation/x", x_m, -kFarthest_m, kFarthest_m);
  require.between("initialisation/y", y_m, -kFarthest_m, kFarthest_m);
  require.between("initialisation/position_stddev", position_stddev_m, least_m, kFarthest_m);
  require.between("initialisation/yaw", yaw_rad, -kTurn_rad, kTurn_rad);
  require.between("initialisation/yaw_stddev", yaw_stddev_rad, is_used ? kLeastAngle_rad : 0.0,
                  kTurn_rad);
  return require.errors();
}

std::vector<std::string> CalibratorConfig::validate() const {
  Requirements require;
  require.add(drive.validate());
  require.add(wheel_noise.validate());
  require.between("wheels/max_apart", max_wheels_apart_s, kBriefest_s, kLongestHistory_s);
  require.between("wheels/history", tick_history_s, kBriefest_s, kLongestHistory_s);
  require.add(bearings.validate());
  require.add(initialisation.validate());
  require.add(initializer.validate());
  require.add(filter.validate());
  require.add(converged.validate());
  require.between("session/max_lights", max_lights, 1, kMostLights);
  require.that(
      filter.parametrisation == FilterConfig::Parametrisation::kCartesian ||
          (errorsInUse(initializer.batch.errors) == 0 && !initializer.noise.any()),
      "filter/parametrisation paper needs every errors/*_stddev 0, as in config/paper.yaml: "
      "its state has no errors of the robot, and its noise is as stated");
  require.that(
      max_lights == 1 || !initializer.batch.errors.usesElevations(),
      "errors/sensor_tilt_stddev needs session/max_lights 1: it estimates the height of one light");
  require.notNegative("refit_growth", refit_growth);
  return require.errors();
}

}  // namespace bearing_calibration::core
