#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/scene.h"

namespace bearing_calibration::core {

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
