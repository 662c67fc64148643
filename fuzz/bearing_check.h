#pragma once

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/optics/bearing.h"
#include "fuzz/harness.h"

namespace bearing_calibration::fuzz {

/// What holds of every bearing that a sensor gives out.
/// @throws std::logic_error for what does not hold
inline void requireBearing(const core::Bearing& bearing) {
  require(std::abs(bearing.azimuth_rad) <= core::kPi, "an azimuth is no angle in [-pi, pi]");
  require(std::isfinite(bearing.azimuth_variance_rad2) && bearing.azimuth_variance_rad2 > 0.0,
          "a variance is not positive and finite");
  require(bearing.probability >= 0.0 && bearing.probability <= 1.0,
          "a probability is not in [0, 1]");
}

}  // namespace bearing_calibration::fuzz
