#pragma once

#include <cstdint>

namespace bearing_calibration::core {

/// Why a drive has ended; the values are those of CalibrationDrive.action.
enum class DriveEnd : std::uint8_t {
  kNone,       ///< it goes on
  kConverged,  ///< the calibration called itself converged
  kCancelled,
  kDisabled,         ///< the enabling input says no
  kObstacle,         ///< the obstacle input says yes
  kTicksLost,        ///< no wheel readings for too long
  kLightLost,        ///< no bearing for too long
  kEstimateLost,     ///< the calibration is silent
  kClockLost,        ///< time stands still
  kLeftRegion,       ///< the base's centre is outside of the region
  kNoWay,            ///< every way would lead too near to the light or out of the region
  kWheelsDisobeyed,  ///< they do not roll as commanded
  kTimeOver,
  kPathOver,
  kShutDown,      ///< the process of the drive node is about to end
  kEnableLost,    ///< the enabling input is silent
  kObstacleLost,  ///< the obstacle input is silent
  kFailed,        ///< an error inside of the drive node
};

/// "CONVERGED" and so on.
const char* nameOf(DriveEnd end);
/// A sentence for the driver: what happened, and what to do.
const char* describe(DriveEnd end);

}  // namespace bearing_calibration::core
