#include "tools/study/random_scene.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"

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
