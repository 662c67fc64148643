#pragma once

#include <cstdint>

namespace bearing_calibration::core {

/// A calibration's life; the values are those of CalibrationEstimate.msg.
enum class CalibrationState : std::uint8_t {
  kWaitingForTicks,
  kWaitingForLight,
  kInitialising,
  kConverging,
  kConverged,
  kDegenerateMotion,
  kInconsistent,
  kPaused,
};

/// "WAITING_FOR_TICKS" and so on.
const char* nameOf(CalibrationState state);

/// What the driver should do in a state, where nothing more precise is known.
const char* adviceFor(CalibrationState state);

}  // namespace bearing_calibration::core
