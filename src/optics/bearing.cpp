#include "bearing_calibration/optics/bearing.h"

#include <cmath>

namespace bearing_calibration::core {

std::optional<Elevation> elevationOf(const Bearing& bearing) {
  const double variance = bearing.elevation_variance_rad2;
  const bool has_one =
      std::isfinite(bearing.elevation_rad) && std::isfinite(variance) && variance > 0.0;
  if (!has_one) return std::nullopt;
  return Elevation{bearing.elevation_rad, variance};
}

}  // namespace bearing_calibration::core
