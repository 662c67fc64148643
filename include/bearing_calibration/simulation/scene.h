#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/clutter.h"
#include "bearing_calibration/simulation/image_renderer.h"
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

/// A light somewhere among clutter drawn for the purpose, seen by a sensor that stands still: the
/// scenes on which detectors are compared (detection.md).
struct RandomSceneConfig {
  RendererConfig rendered;  ///< its holders and seed are those of the scene
  ClutterConfig clutter;
  Interval wall_brightness{0.03, 0.15};  ///< [full wells]
  Interval distance_m{0.3, 4.0};         ///< of the lights, evenly in the logarithm
  Interval peak_levels{90.0, 400.0};     ///< as left by an exposure control that does not know them
  int lights = 1;                        ///< like ones; the first is looked for
  double light_radius_m = 0.0;
};

struct RandomScene {
  std::vector<Light> lights;                ///< the first is looked for
  std::unique_ptr<ImageRenderer> renderer;  ///< of the scene: for more images of it
  cv::Mat image;                            ///< CV_8UC1, with all lights
  double light_azimuth_rad = 0.0;  ///< of the light that is looked for; not behind a holder
  std::vector<MirrorHolder> holders;
};

/// The same seed gives the same scene.
RandomScene randomScene(const RandomSceneConfig& config, std::uint64_t seed);

}  // namespace bearing_calibration::core
