#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/clutter.h"
#include "bearing_calibration/simulation/led_ring.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/panorama.h"

namespace bearing_calibration::core {

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
