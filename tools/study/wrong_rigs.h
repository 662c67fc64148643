#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"

namespace bearing_calibration::core {

/// A rig that differs from what its detector is told in one value.
struct WrongRig {
  std::string name;
  RendererConfig rendered;
  double light_height_m = 0.0;  ///< over the mirror's apex
};

/// The right one, and each wrong value in both directions.
std::vector<WrongRig> wrongRigs(const RendererConfig& right);

}  // namespace bearing_calibration::core
