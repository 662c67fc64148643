#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration {

/// Whether a stamp can be that of a message received at `received`.
InputOutcome checkStamp(Stamp stamp, Stamp received, double max_future_s);

/// Whether a candidate is a bearing at all.
InputOutcome checkCandidate(const Bearing& candidate, const BearingInputConfig& config);

/// The good candidates of a message, with the configured noise added and on the encoders' clock.
struct CheckedBearings {
  BearingSet bearings;
  std::vector<InputOutcome> remarks;  ///< what was wrong with the others, and changed in these
};
CheckedBearings checkBearings(const BearingSet& bearings, const BearingInputConfig& config);

/// `advice` for the driver, unless the sensor's owner has to be told something first: more than one
/// in a hundred of the bearings used is beyond a turn, or had its variance raised.
std::string adviceWithSensor(const InputCounts& bearing_inputs, std::uint32_t bearings_used,
                             const std::string& advice);

}  // namespace bearing_calibration
