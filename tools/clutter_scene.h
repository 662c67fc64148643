#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration {

/// A ray-traced image of a light among things that may be taken for it: windows, lamps over the
/// horizon, reflections on the floor, texture, the mirror's posts, its bright centre.
struct ClutterScene {
  cv::Mat image;                   ///< CV_8UC1
  double light_azimuth_rad = 0.0;  ///< of the light that is looked for
  std::vector<MirrorPost> posts;
};

struct ClutterConfig {
  RendererConfig rendered;
  int lights = 1;  ///< like ones; the first is looked for
};

/// The same seed gives the same scene. The light stands 0.3 to 4 m away, 30 mm below the apex, not
/// behind a post, and peaks at 90 to 400 of 255 levels (as left by an exposure control that does
/// not know it).
ClutterScene clutterScene(const ClutterConfig& config, std::uint64_t seed);

}  // namespace bearing_calibration
