#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Whether a bearing is where a light is expected: within four standard deviations.
bool isWhereExpected(const AzimuthPrediction& light, const Bearing& candidate);

/// The turn of the base [rad] that its wheels do not show, because they have slipped: it takes
/// several lights that nobody has numbered off from where they are expected, all by the same angle.
/// None where most are where they are expected, where no such turn explains them, or more than one.
/// @param expected  azimuths of the lights
std::optional<double> hiddenTurn(const std::vector<AzimuthPrediction>& expected,
                                 const std::vector<Bearing>& candidates);

}  // namespace bearing_calibration::core
