#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/simulation/cone_tracer.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/light_spot.h"
#include "bearing_calibration/simulation/panorama.h"
#include "bearing_calibration/simulation/pixel_noise.h"

namespace bearing_calibration {

/// An 8-bit grey image, row by row without gaps.
struct MonoImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> values;
};

struct RendererConfig {
  CameraRig rig;
  PixelConfig pixels;
  /// The exposure is set so that a light of brightness 1 at this distance, seen along the sensor's
  /// x axis, reaches this value of 255 in the middle of its spot.
  double reference_value = 180.0;
  double reference_distance_m = 1.5;
  double reference_height_m = -0.03;
  double outside_mirror = 0.01;     ///< what is seen past the mirror [full wells]
  double centre_radius_px = 25.0;   ///< the cone's blunt tip, which shows the camera itself
  double centre_brightness = 0.15;  ///< [full wells]
  int rays_per_light = 4096;
  std::uint64_t seed = 1;  ///< of the noise

  std::vector<std::string> validate() const;
};

/// Images of lights and surroundings as the camera of a CameraRig takes them.
class ImageRenderer {
 public:
  /// @throws std::invalid_argument with what config.validate() says.
  ImageRenderer(const RendererConfig& config, const RadianceFunction& surroundings);

  /// The expected photo-electrons of each pixel, without noise and saturation.
  const std::vector<float>& expose(const std::vector<Light>& lights,
                                   const Pose2& world_from_sensor);

  /// An image with all noise. The same number gives the same noise.
  MonoImage render(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                   std::uint64_t image_number);

  const ConeTracer& tracer() const { return tracer_; }

 private:
  RendererConfig config_;
  ConeTracer tracer_;
  PixelNoise noise_;
  LightSpot spot_;
  Panorama panorama_;
  double electrons_per_flux_ = 0.0;
  std::vector<Panorama::Place> places_;  ///< of each pixel; row -1 past the mirror
  std::vector<float> fixed_electrons_;   ///< of pixels that do not see the surroundings
  std::vector<float> electrons_;
};

}  // namespace bearing_calibration
