#include "bearing_calibration/calibration/mount_calibration.h"

namespace bearing_calibration::core {

void MountCalibration::describe(CalibrationResult* result) const {
  result->error_priors = config_.initializer.batch.errors;
  result->robot_errors = priorEstimate(config_.initializer.batch.errors);
  result->noise_priors = config_.initializer.noise;
  result->noise = noise_;
  result->correlation_time = correlation_time_;
  result->rival = rival_;
  result->bearings_used = bearings_used_;
  result->bearings_gated = bearings_gated_;
  std::optional<CartesianEstimate> own;
  if (const std::optional<MountTracker>& known = tracker_ ? tracker_ : search_.weak(); known) {
    const StateEstimate estimate = known->filter().estimate();
    sayEstimate(estimate, result);
    if (config_.filter.parametrisation == FilterConfig::Parametrisation::kPaper) {
      result->paper_state = known->filter().paper();
    }
    own = estimate.cartesian();
    const Consistency consistency = known->consistency();
    result->nis = consistency.nis;
    result->nis_mean = consistency.nis_mean;
  }
  if (started_) {
    result->state = judge_->last().state;
    result->advice = judge_->last().advice;
    result->cause = judge_->last().cause;
    if (isRefuted()) result->state = CalibrationState::kInconsistent;
  } else {
    search_.describe(result);
  }
  result->lights = {{lightId(), result->state, own, true, bearings_used_, ""}};
  if (result->state == CalibrationState::kInconsistent && diagnosis_.fault != Fault::kNone &&
      diagnosis_.fault != result->cause) {
    result->advice = ::bearing_calibration::core::describe(diagnosis_);
    result->cause = diagnosis_.fault;
  }
  if (restarted_) sayRestarted(result);
}

}  // namespace bearing_calibration::core
