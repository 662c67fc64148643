#include "bearing_calibration/simulation/scene.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

Light randomLight(const RandomSceneConfig& config, double azimuth_rad, SceneRandom* random) {
  const RendererConfig& rendered = config.rendered;
  const double distance_m = std::exp(
      drawBetween({std::log(config.distance_m.low), std::log(config.distance_m.high)}, random));
  const double peak_levels = drawBetween(config.peak_levels, random);
  Light light;
  light.position_m = distance_m * Eigen::Vector2d(std::cos(azimuth_rad), std::sin(azimuth_rad));
  light.height_m = rendered.reference_height_m;
  light.radius_m = config.light_radius_m;
  light.brightness = peak_levels / rendered.reference_value *
                     std::pow(distance_m / rendered.reference_distance_m, 2);
  return light;
}

}  // namespace

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

RandomScene randomScene(const RandomSceneConfig& config, std::uint64_t seed) {
  // From a holder's edge to the light: what a mask adds, and half of a spot (6 px of a radius of
  // 160 px).
  constexpr double kMaskMargin_rad = radiansFromDegrees(1.0);
  constexpr double kHalfSpot_rad = radiansFromDegrees(2.2);
  SceneRandom random(seed);
  const Clutter clutter = drawClutter(config.clutter, &random);
  const double wall = drawBetween(config.wall_brightness, &random);
  RandomScene scene;
  scene.holders = drawHolders(config.clutter, &random);
  while (static_cast<int>(scene.lights.size()) < config.lights) {
    const double azimuth_rad = drawBetween({-kPi, kPi}, &random);
    if (isBehind(scene.holders, azimuth_rad, kMaskMargin_rad + kHalfSpot_rad)) continue;
    if (scene.lights.empty()) scene.light_azimuth_rad = azimuth_rad;
    scene.lights.push_back(randomLight(config, azimuth_rad, &random));
  }
  RendererConfig rendered = config.rendered;
  rendered.holders = scene.holders;
  rendered.seed = seed;
  const auto walls = [wall](double, double) { return wall; };
  scene.renderer = std::make_unique<ImageRenderer>(rendered, withClutter(walls, clutter));
  scene.image = scene.renderer->render(scene.lights, {}, seed);
  return scene;
}

}  // namespace bearing_calibration::core
