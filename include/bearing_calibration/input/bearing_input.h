#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// The bounds of the bearings' input and their noise. Parameter group `bearings`.
struct BearingInputConfig {
  /// Seconds to take off a bearing's stamp to get the moment on the encoders' clock at which the
  /// light was seen: positive when the camera's stamps are late.
  double latency_s = 0.0;
  /// What the sensor's own variance does not contain (mount, mirror, light): added to each [rad].
  double extra_stddev_rad = 0.0;
  double min_stddev_rad = 0.0;  ///< a stated one below it, of azimuth or elevation, is raised to it
  double max_stddev_rad = 0.0;  ///< a candidate with a larger one is refused
  double max_future_s = 0.0;    ///< a stamp later than its receipt by more is refused
  /// Bearings wait for ticks so long after their stamp, and for earlier ones of other sensors [s].
  double reorder_window_s = 0.0;
  int max_waiting = 0;           ///< messages that may wait for ticks before the oldest is dropped
  double min_probability = 0.0;  ///< candidates of lower probability are not considered

  void declare(Parameters& params);
};

/// Whether a stamp can be that of a message received at `received`.
InputOutcome checkStamp(Stamp stamp, Stamp received, double max_future_s);

/// Whether a mirror can be so.
InputOutcome checkGeometry(const SensorGeometry& geometry);

/// Whether a sensor can see so.
InputOutcome checkView(const FieldOfView& view);

/// The good candidates of a message on the encoders' clock, with the configured noise added, and
/// what the sensor's geometry does that no error of the robot describes.
struct CheckedBearings {
  BearingSet bearings;
  std::vector<InputOutcome> remarks;  ///< what was wrong with the others, and changed in these
};
CheckedBearings checkBearings(const BearingSet& bearings, const BearingInputConfig& config);

/// `advice` for the driver, unless the sensor's owner has to be told something first: more than one
/// in a hundred of the bearings used is beyond a turn, or had its variance raised.
std::string adviceWithSensor(const InputCounts& bearing_inputs, std::uint32_t bearings_used,
                             const std::string& advice);

}  // namespace bearing_calibration::core
