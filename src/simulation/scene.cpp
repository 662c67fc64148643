#include "bearing_calibration/simulation/scene.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

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

void SceneConfig::declare(Parameters& params) {
  constexpr double kDarkest = 1e-6;
  constexpr double kBrightest = 1e6;
  constexpr double kLargest_m = 10.0;
  params.list("world/lights", 5, lights, [](const auto& row) {
    return Light{{row[0], row[1]}, row[2], row[3], row[4]};
  });
  for (const Light& light : lights) {
    const Eigen::Vector3d place_m(light.position_m.x(), light.position_m.y(), light.height_m);
    params.between("world/lights: the distance", place_m.cwiseAbs().maxCoeff(), 0.0,
                   plausible::kFarthest_m);
    params.between("world/lights: the brightness", light.brightness, kDarkest, kBrightest);
    params.between("world/lights: the radius", light.radius_m, 0.0, kLargest_m);
  }
  ring.declare(params);
  room.declare(params);
  clutter.declare(params);
}

Scene drawScene(const SceneConfig& config, std::uint64_t seed) {
  validated(config);
  SceneRandom random(seed);
  Scene scene;
  scene.surroundings = withClutter(roomRadiance(config.room), drawClutter(config.clutter, &random));
  scene.holders = drawHolders(config.clutter, &random);
  for (const Light& light : config.lights) {
    for (const Light& led : drawLeds(light, config.ring, &random)) scene.lights.push_back(led);
  }
  return scene;
}

}  // namespace bearing_calibration::core
