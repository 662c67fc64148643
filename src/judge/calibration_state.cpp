#include "bearing_calibration/judge/calibration_state.h"

namespace bearing_calibration::core {

const char* nameOf(CalibrationState state) {
  switch (state) {
    case CalibrationState::kWaitingForTicks:
      return "WAITING_FOR_TICKS";
    case CalibrationState::kWaitingForLight:
      return "WAITING_FOR_LIGHT";
    case CalibrationState::kInitialising:
      return "INITIALISING";
    case CalibrationState::kConverging:
      return "CONVERGING";
    case CalibrationState::kConverged:
      return "CONVERGED";
    case CalibrationState::kDegenerateMotion:
      return "DEGENERATE_MOTION";
    case CalibrationState::kInconsistent:
      return "INCONSISTENT";
    case CalibrationState::kPaused:
      return "PAUSED";
  }
  return "UNKNOWN";
}

const char* adviceFor(CalibrationState state) {
  switch (state) {
    case CalibrationState::kWaitingForTicks:
      return "no wheel readings yet that can be used: check their topic, and rejections";
    case CalibrationState::kWaitingForLight:
      return "no bearing yet: bring the light into view";
    case CalibrationState::kInitialising:
      return "drive about 1 m straight, turn on the spot, repeat";
    case CalibrationState::kConverging:
      return "keep driving straight lines and turns near the light";
    case CalibrationState::kConverged:
      return "the calibration is done: save it";
    case CalibrationState::kDegenerateMotion:
      return "the mount is not observable with this motion: drive straight lines and turns";
    case CalibrationState::kInconsistent:
      return "the bearings do not fit the wheels' motion";
    case CalibrationState::kPaused:
      return "paused: call ~pause with false to go on";
  }
  return "";
}

}  // namespace bearing_calibration::core
