#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/clutter.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/panorama.h"

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

/// The world around the camera. Parameter groups `world`, `ring`, `surroundings` and `clutter`.
struct SceneConfig {
  std::vector<Light> lights;  ///< their middles, where they are rings
  LedRing ring;
  RoomLook room;
  ClutterConfig clutter;

  void declare(Parameters& params);
};

/// What the camera is shown of it.
struct Scene {
  std::vector<Light> lights;  ///< each LED is one
  RadianceFunction surroundings;
  std::vector<MirrorHolder> holders;
};

/// The same seed gives the same scene. @throws std::invalid_argument with what errorsOf() says.
Scene drawScene(const SceneConfig& config, std::uint64_t seed);

}  // namespace bearing_calibration::core
