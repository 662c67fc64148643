#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

void sayRestarted(CalibrationResult* result) {
  if (result->state == CalibrationState::kConverged) return;
  result->advice = "the mount has moved and is calibrated anew: " +
                   (result->advice.empty() ? adviceFor(result->state) : result->advice);
}

}  // namespace bearing_calibration::core
