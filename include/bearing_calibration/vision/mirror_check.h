#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/mirror_rim.h"

namespace bearing_calibration::core {

/// What the mirror's rim, as seen, says of the configuration.
struct MirrorCheck {
  bool consistent = true;
  std::vector<std::string> sentences;  ///< what was compared, and what to change
};

/// Compares the rim's centre with the configured one (by both uncertainties), its radius with the
/// one that lens and mirror make, and the mask with the rim.
MirrorCheck checkMirror(const MirrorRim& rim, const DetectorConfig& config);

}  // namespace bearing_calibration::core
