#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration/vision/light_bearings.h"
#include "support/rendered_observations.h"

namespace bearing_calibration::core {
namespace test {

/// A camera and a light in one condition, and what the detector is told of it.
struct RenderedSeries {
  std::string name;
  RendererConfig rendered;
  LedRing ring;
  double brightness = 1.0;  ///< times what gives the renderer's reference value
  double turn_radps = 0.0;
  DetectorConfig detector;
  ShutterConfig shutter;
};

/// The rows of the table in detection.md.
std::vector<RenderedSeries> renderedSeries();
/// @throws std::out_of_range when there is none of that name.
RenderedSeries renderedSeries(const std::string& name);

/// Bearings of `images` random observations, by way of the image message's encoding, each against
/// the light's azimuth at the moment that the bearing's stamp names. Images in which the light is
/// not the only one found are left out.
BearingErrors errorsOf(const RenderedSeries& series, int images, unsigned seed);
BearingErrors errorsOf(const RenderedSeries& series, const std::vector<Observation>& observations);

}  // namespace test
}  // namespace bearing_calibration::core
