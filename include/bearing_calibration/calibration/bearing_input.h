#pragma once

#include <vector>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration {

/// Whether a stamp can be that of a message received at `received`.
InputOutcome checkStamp(Stamp stamp, Stamp received, double max_future_s);

/// Whether a candidate is a bearing at all.
InputOutcome checkCandidate(const Bearing& candidate, const BearingInputConfig& config);

/// The good candidates of a message, with the configured noise added and on the encoders' clock,
/// and what was wrong with each of the others.
struct CheckedBearings {
  BearingSet bearings;
  std::vector<InputOutcome> refused;
};
CheckedBearings checkBearings(const BearingSet& bearings, const BearingInputConfig& config);

}  // namespace bearing_calibration
