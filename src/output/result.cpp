#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

bool mayBeTrusted(CalibrationState state) {
  return state == CalibrationState::kConverged || state == CalibrationState::kConverging;
}

void sayEstimate(const RobotEstimate& estimate, CalibrationResult* result) {
  const CartesianEstimate cartesian =
      withNearness(estimate.cartesian, result->error_priors.nearness_stddev_m);
  result->cartesian_state = cartesian;
  result->robot_errors = estimate.errors;
  result->paper_state = paperFromCartesian(cartesian);
  result->base_from_sensor = mountFromCartesian(cartesian);
}

void sayRestarted(CalibrationResult* result) {
  if (result->state == CalibrationState::kConverged) return;
  result->advice = "the mount has moved and is calibrated anew: " +
                   (result->advice.empty() ? adviceFor(result->state) : result->advice);
}

}  // namespace bearing_calibration::core
