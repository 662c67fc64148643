#include "bearing_calibration/simulation/led_ring.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

void LedRing::declare(Parameters& params) {
  constexpr int kMostLeds = 64;  // each of them costs as much as a light
  constexpr double kLargest_m = 10.0;
  params.integer("ring/leds", leds, 0, kMostLeds);
  params.number("ring/radius", radius_m, 0.0, kLargest_m);
  params.number("ring/brightness_spread", brightness_spread, 0.0, 1.0);
}

std::vector<Light> drawLeds(const Light& light, const LedRing& ring, SceneRandom* random) {
  if (ring.leds == 0) return {light};
  std::normal_distribution<double> normal(1.0, ring.brightness_spread);
  std::vector<Light> leds;
  for (int i = 0; i < ring.leds; ++i) {
    const double angle_rad = 2.0 * kPi * i / ring.leds;
    Light led = light;
    led.position_m += ring.radius_m * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    led.brightness *= std::max(0.0, normal(*random)) / ring.leds;
    led.radius_m = 0.0;
    leds.push_back(led);
  }
  return leds;
}

}  // namespace bearing_calibration::core
