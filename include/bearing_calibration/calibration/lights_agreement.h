#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/paper_state.h"

namespace bearing_calibration {

/// Which of several lights say the same mount. One that moves, or a reflection, may well say a
/// mount, and be sure of it; but not that of the others.
struct LightsAgreement {
  std::vector<std::size_t> agreeing;  ///< indices of those that all agree with each other
  std::vector<std::size_t> contradicting;
  /// More agree than contradict. With two that do not, nobody knows which one is right.
  bool has_majority = false;
  /// No two of those that agree are so far apart that a verdict had better wait.
  bool is_clear = true;
};

/// @param mounts  one for each light, each from that light's bearings alone. They share the wheels'
///   noise, which brings them nearer to each other than independent ones would be.
LightsAgreement compareLights(const std::vector<MountEstimate>& mounts);

}  // namespace bearing_calibration
