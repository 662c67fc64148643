#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/simulation/image_sensor.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/light_spot.h"
#include "bearing_calibration/simulation/panorama.h"
#include "bearing_calibration/simulation/scene.h"

namespace bearing_calibration::core {

struct RendererConfig {
  CameraRig rig;
  PixelConfig pixels;
  Shutter shutter;
  ImageEncoding encoding;
  std::vector<MirrorHolder> holders;
  /// The exposure is set so that a light of brightness 1 at this distance, seen along the sensor's
  /// x axis, reaches this value of 255 in the middle of its spot.
  double reference_value = 180.0;
  double reference_distance_m = 1.0;
  double reference_height_m = -0.03;
  double outside_mirror = 0.01;     ///< what is seen past the mirror [full wells]
  double centre_radius_px = 25.0;   ///< the cone's blunt tip, which shows the camera itself
  double centre_brightness = 0.15;  ///< [full wells]
  int rays_per_light = 4096;
  std::uint64_t seed = 1;  ///< of the noise

  void declare(Parameters& params);
};

/// Images of lights and surroundings as the camera of a CameraRig takes them.
class ImageRenderer {
 public:
  /// @throws std::invalid_argument with what errorsOf() says.
  ImageRenderer(const RendererConfig& config, const RadianceFunction& surroundings);

  /// The expected photo-electrons of each pixel, without noise and saturation.
  const std::vector<float>& expose(const std::vector<Light>& lights, const SensorMotion& motion);

  /// The sensor's values (CV_8UC1) with all noise; encode() makes the driver's image of them. The
  /// same number gives the same noise.
  cv::Mat render(const std::vector<Light>& lights, const SensorMotion& motion,
                 std::uint64_t image_number);

  /// Where the image shows a light, and what a perfect sensor would have said of it then.
  struct Truth {
    double time_s = 0.0;  ///< mid-exposure of the light's row, after that of the first row
    double azimuth_rad = 0.0;
    double elevation_rad = 0.0;                       ///< from the origin of the sensor frame
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< (column, row)
  };
  /// None when the mirror does not show it. A holder in front is not looked for.
  std::optional<Truth> truthOf(const Light& light, const SensorMotion& motion) const;

  const ConeTracer& tracer() const { return spot_.tracer(); }
  const RendererConfig& config() const { return config_; }

 private:
  void exposeSurroundings(const SensorMotion& motion);

  RendererConfig config_;
  LightSpot spot_;
  Panorama panorama_;
  double electrons_per_flux_ = 0.0;
  std::vector<Panorama::Place> places_;  ///< of each pixel; row -1 past the mirror
  std::vector<float> fixed_electrons_;   ///< of pixels that do not see the surroundings
  std::vector<float> transmission_;      ///< of each pixel, by holders and colour filter
  std::vector<float> electrons_;
};

}  // namespace bearing_calibration::core
