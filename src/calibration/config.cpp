#include "bearing_calibration/calibration/config.h"

#include "bearing_calibration/common/parameters.h"
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

void InitialisationConfig::declare(Parameters& params) {
  params.choice("initialisation/from", {"nothing", "guess"}, kind);
  const bool is_used = kind == Kind::kGuess;
  const double least_m = is_used ? kLeastLength_m : 0.0;
  params.number("initialisation/light_distance", light_distance_m, least_m, kFarthest_m);
  params.number("initialisation/light_distance_stddev", light_distance_stddev_m, least_m,
                kFarthest_m);
  params.number("initialisation/x", x_m, -kFarthest_m, kFarthest_m);
  params.number("initialisation/y", y_m, -kFarthest_m, kFarthest_m);
  params.number("initialisation/position_stddev", position_stddev_m, least_m, kFarthest_m);
  params.number("initialisation/yaw", yaw_rad, -kTurn_rad, kTurn_rad);
  params.number("initialisation/yaw_stddev", yaw_stddev_rad, is_used ? kLeastAngle_rad : 0.0,
                kTurn_rad);
}

void CalibratorConfig::declare(Parameters& params) {
  drive.declare(params);
  wheel_noise.declare(params);
  wheel_times.declare(params);
  bearings.declare(params);
  initialisation.declare(params);
  initializer.declare(params);
  filter.declare(params);
  converged.declare(params);
  params.integer("session/max_lights", max_lights, 1, kMostLights);
  params.read("session/restart_on_mount_change", restart_on_mount_change);
  params.that(
      filter.parametrisation == FilterConfig::Parametrisation::kCartesian ||
          (errorsInUse(initializer.batch.errors) == 0 && !initializer.noise.any()),
      "filter/parametrisation paper needs every errors/*_stddev 0, as in config/paper.yaml: "
      "its state has no errors of the robot, and its noise is as stated");
  params.that(
      max_lights == 1 || !initializer.batch.errors.usesElevations(),
      "errors/sensor_tilt_stddev needs session/max_lights 1: it estimates the height of one light");
  params.notNegative("refit_growth", refit_growth);
}

}  // namespace bearing_calibration::core
