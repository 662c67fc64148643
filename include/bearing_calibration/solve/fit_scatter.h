#pragma once

#include <cstddef>

#include "bearing_calibration/filter/lights_state.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/record/scatter.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {

/// That of the whole drive, what the record has given away counted.
Scatter scatterOf(const BatchEstimate& fit);
/// That of a part of the record, against all of it.
/// @param begin,end  observations of the fit
Scatter scatterOf(const BatchEstimate& fit, std::size_t begin, std::size_t end);

/// The same estimate with the covariance of mount and lights so many times larger. The robot's
/// errors keep theirs, which an earlier calibration may be subtracted from, and all correlations.
RobotEstimate widened(RobotEstimate estimate, double widening);
LightsEstimate widened(LightsEstimate estimate, double widening);

}  // namespace bearing_calibration::core
