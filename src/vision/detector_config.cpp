#include "bearing_calibration/vision/detector_config.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration {
namespace {

// Wider images are stitched or wrong; integer moments and memory are made for this.
constexpr int kMaxImageSide_px = 16384;
constexpr double kLargestLevel = 65535.0;  // of a 16-bit image
constexpr double kMaxDefocus_px = 20.0;    // beyond, a light is as wide as the mirror's annulus
constexpr int kMaxCandidates = 1000;

void checkSensor(const ImageSensor& sensor, Requirements* require) {
  require->between("sensor/width", sensor.width_px, 1.0, kMaxImageSide_px);
  require->between("sensor/height", sensor.height_px, 1.0, kMaxImageSide_px);
  require->positive("sensor/electrons_per_level", sensor.electrons_per_level);
  require->notNegative("sensor/black_level", sensor.black_level);
  require->between("sensor/saturation_level", sensor.saturation_level, 1.0, kLargestLevel);
  require->that(sensor.black_level < sensor.saturation_level,
                "sensor/black_level must be less than sensor/saturation_level");
  require->notNegative("sensor/read_noise", sensor.read_noise_electrons);
  require->notNegative("sensor/response_spread", sensor.response_spread);
}

void checkMask(const MaskConfig& mask, const ImageSensor& sensor, Requirements* require) {
  require->notNegative("mask/inner_radius", mask.inner_radius_px);
  require->between("mask/outer_radius", mask.outer_radius_px, 1.0, kMaxImageSide_px);
  require->that(mask.inner_radius_px < mask.outer_radius_px,
                "mask/inner_radius must be less than mask/outer_radius");
  require->between("mask/first_row", mask.first_row, 0.0, sensor.height_px - 1.0);
  require->between("mask/last_row", mask.last_row, mask.first_row, sensor.height_px - 1.0);
  for (const MirrorPost& post : mask.posts) {
    require->between("mask/posts azimuth", post.azimuth_rad, -2.0 * kPi, 2.0 * kPi);
    require->between("mask/posts half width", post.half_width_rad, 0.0, kPi);
  }
}

void checkLight(const LightModel& light, const ConicMirror& mirror, Requirements* require) {
  // A light inside the mirror's own radius has no path over it.
  require->that(light.min_distance_m > mirror.base_radius_m,
                "light/min_distance must be greater than mirror/base_radius, but is " +
                    std::to_string(light.min_distance_m));
  require->that(std::isfinite(light.max_distance_m) && light.max_distance_m > light.min_distance_m,
                "light/max_distance must be greater than light/min_distance, but is " +
                    std::to_string(light.max_distance_m));
  require->notNegative("light/radius", light.radius_m);
  require->notNegative("light/half_height", light.half_height_m);
  require->between("light/brightness_spread", light.brightness_spread, 0.0, 1.0);
}

void checkGates(const GateConfig& gates, Requirements* require) {
  require->between("gates/min_pixels", gates.min_pixels, 1.0, gates.max_pixels);
  require->between("gates/min_fill", gates.min_fill, 0.0, 1.0);
  require->between("gates/max_fill", gates.max_fill, 1.0, 2.0);
  require->that(gates.min_fill < 1.0, "gates/min_fill must be less than 1");
  require->that(gates.max_fill > 1.0, "gates/max_fill must be greater than 1");
  require->positive("gates/size_tolerance", gates.size_tolerance);
  require->positive("gates/peakedness_tolerance", gates.peakedness_tolerance);
  require->between("gates/min_quality", gates.min_quality, 0.0, 1.0);
  require->positive("gates/max_axis_error", gates.max_axis_error_rad);
}

}  // namespace

std::vector<std::string> DetectorConfig::validate() const {
  Requirements require;
  checkSensor(sensor, &require);
  require.add(mirror.validate());
  require.that(std::isfinite(view.centre_u_px), "mirror/centre_u must be finite");
  require.that(std::isfinite(view.centre_v_px), "mirror/centre_v must be finite");
  require.that(view.handedness == 1 || view.handedness == -1,
               "mirror/handedness must be 1 or -1, but is " + std::to_string(view.handedness));
  checkMask(mask, sensor, &require);
  require.positive("threshold/min_contrast", threshold.min_contrast_levels);
  require.notNegative("threshold/spreads", threshold.spreads);
  checkLight(light, mirror, &require);
  checkGates(gates, &require);
  require.that(
      !gates.mirror || !mirror.validate().empty() || mask.inner_radius_px < rimRadiusPx(mirror),
      "mask/inner_radius must be less than the mirror's rim, which lens and mirror put at " +
          std::to_string(rimRadiusPx(mirror)) + " px");
  require.notNegative("alignment/centre_stddev", alignment.centre_stddev_px);
  require.notNegative("alignment/azimuth_stddev", alignment.azimuth_stddev_rad);
  require.notNegative("alignment/elevation_stddev", alignment.elevation_stddev_rad);
  require.between("defocus/sigma", defocus_sigma_px, 0.0, kMaxDefocus_px);
  require.between("gates/max_candidates", max_candidates, 1.0, kMaxCandidates);
  return require.errors();
}

}  // namespace bearing_calibration
