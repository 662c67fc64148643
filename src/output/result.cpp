#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

void UnestimatedMount::declare(Parameters& params) {
  using namespace plausible;
  params.number("mount/z", z_m, -kFarthest_m, kFarthest_m);
  params.number("mount/roll", roll_rad, -kPi, kPi);
  params.number("mount/pitch", pitch_rad, -0.5 * kPi, 0.5 * kPi);
  params.number("mount/z_stddev", z_stddev_m, kLeastLength_m, kFarthest_m);
  params.number("mount/roll_stddev", roll_stddev_rad, kLeastAngle_rad, kTurn_rad);
  params.number("mount/pitch_stddev", pitch_stddev_rad, kLeastAngle_rad, kTurn_rad);
}

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
