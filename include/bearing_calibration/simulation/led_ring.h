#pragma once

#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/scene_random.h"

namespace bearing_calibration::core {

/// LEDs evenly around a holder, not quite equally bright: their centroid is not its centre.
struct LedRing {
  int leds = 0;  ///< 0: lights stay single balls
  double radius_m = 0.02;
  double brightness_spread = 0.1;  ///< relative standard deviation among the LEDs

  void declare(Parameters& params);
};

/// `light` as a horizontal ring of points around its position, equally bright together on average;
/// `light` itself when the ring has no LEDs.
std::vector<Light> drawLeds(const Light& light, const LedRing& ring, SceneRandom* random);

}  // namespace bearing_calibration::core
