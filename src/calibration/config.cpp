#include "bearing_calibration/calibration/config.h"

#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

void CalibratorConfig::declare(Parameters& params) {
  drive.declare(params);
  wheel_noise.declare(params);
  wheel_times.declare(params);
  bearings.declare(params);
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
  params.notNegative("refit_growth", refit_growth);
}

}  // namespace bearing_calibration::core
