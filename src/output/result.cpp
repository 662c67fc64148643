#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

bool mayBeTrusted(CalibrationState state) {
  return state == CalibrationState::kConverged || state == CalibrationState::kConverging;
}

void sayEstimate(const StateEstimate& estimate, CalibrationResult* result) {
  result->estimate = withNearness(estimate, result->error_priors.nearness_stddev_m);
  const CartesianEstimate cartesian = result->estimate->cartesian();
  result->cartesian_state = cartesian;
  result->robot_errors = estimate.errors();
  result->paper_state = paperFromCartesian(cartesian);
  result->base_from_sensor = result->estimate->mount();
}

void sayRestarted(CalibrationResult* result) {
  if (result->state == CalibrationState::kConverged) return;
  result->advice = "the mount has moved and is calibrated anew: " +
                   (result->advice.empty() ? adviceFor(result->state) : result->advice);
}

}  // namespace bearing_calibration::core
