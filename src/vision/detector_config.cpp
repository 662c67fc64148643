#include "bearing_calibration/vision/detector_config.h"

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {

using namespace plausible;

namespace {

constexpr double kLargestLevel = 65535.0;  // of a 16-bit image
constexpr double kMaxDefocus_px = 20.0;    // beyond, a light is as wide as the mirror's annulus
constexpr int kMaxCandidates = 1000;
constexpr double kMaxElectrons = 1e9;  // of a pixel
constexpr double kMaxPixels = kLargestSide_px * kLargestSide_px;
constexpr double kLargestLight_m = 10.0;

void checkSensor(const ImageSensor& sensor, Requirements* require) {
  require->between("sensor/width", sensor.width_px, 1.0, kLargestSide_px);
  require->between("sensor/height", sensor.height_px, 1.0, kLargestSide_px);
  require->between("sensor/electrons_per_level", sensor.electrons_per_level, 1.0 / kLargestLevel,
                   kMaxElectrons);
  require->between("sensor/black_level", sensor.black_level, 0.0, kLargestLevel);
  require->between("sensor/saturation_level", sensor.saturation_level, 1.0, kLargestLevel);
  require->that(sensor.black_level < sensor.saturation_level,
                "sensor/black_level must be less than sensor/saturation_level");
  require->between("sensor/read_noise", sensor.read_noise_electrons, 0.0, kMaxElectrons);
  require->between("sensor/response_spread", sensor.response_spread, 0.0, 1.0);
}

void checkMask(const MaskConfig& mask, const ImageSensor& sensor, Requirements* require) {
  require->between("mask/inner_radius", mask.inner_radius_px, 0.0, kLargestSide_px);
  require->between("mask/outer_radius", mask.outer_radius_px, 1.0, kLargestSide_px);
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
                "light/min_distance must be greater than mirror/base_radius");
  require->that(light.max_distance_m > light.min_distance_m,
                "light/max_distance must be greater than light/min_distance");
  require->between("light/min_distance", light.min_distance_m, kShortest_m, kFarthest_m);
  require->between("light/max_distance", light.max_distance_m, kShortest_m, kFarthest_m);
  require->between("light/min_radius", light.min_radius_m, 0.0, light.radius_m);
  require->between("light/radius", light.radius_m, 0.0, kLargestLight_m);
  require->between("light/half_height", light.half_height_m, 0.0, kLargestLight_m);
  require->between("light/brightness_spread", light.brightness_spread, 0.0, 1.0);
  require->between("light/max_height", light.max_height_m, 0.0, kFarthest_m);
}

void checkGates(const GateConfig& gates, Requirements* require) {
  require->between("gates/max_pixels", gates.max_pixels, 1.0, kMaxPixels);
  require->between("gates/min_pixels", gates.min_pixels, 1.0, gates.max_pixels);
  require->between("gates/min_probability", gates.min_probability, 0.0, 1.0);
}

void checkOptics(const OpticsUncertainty& stddev, Requirements* require) {
  constexpr double kHalf = 0.5;  // beyond, an optics value says nothing
  require->between("lens/scale_stddev", stddev.scale, 0.0, kHalf);
  require->between("lens/aperture_stddev", stddev.aperture, 0.0, kHalf);
  require->between("lens/focus_stddev", stddev.focus, 0.0, kHalf);
  require->between("mirror/half_angle_stddev", stddev.half_angle_rad, 0.0,
                   radiansFromDegrees(10.0));
}

}  // namespace

std::vector<std::string> DetectorConfig::validate() const {
  Requirements require;
  checkSensor(sensor, &require);
  require.add(mirror.validate());
  checkOptics(optics_stddev, &require);
  require.between("mirror/centre_u", view.centre_u_px, -kLargestSide_px, 2.0 * kLargestSide_px);
  require.between("mirror/centre_v", view.centre_v_px, -kLargestSide_px, 2.0 * kLargestSide_px);
  require.that(view.handedness == 1 || view.handedness == -1,
               "mirror/handedness must be 1 or -1, but is " + std::to_string(view.handedness));
  checkMask(mask, sensor, &require);
  require.between("threshold/min_contrast", threshold.min_contrast_levels, 1.0 / kLargestLevel,
                  kLargestLevel);
  require.between("threshold/spreads", threshold.spreads, 0.0, kMostSigmas);
  checkLight(light, mirror, &require);
  checkGates(gates, &require);
  require.that(
      !gates.mirror || !mirror.validate().empty() || mask.inner_radius_px < rimRadiusPx(mirror),
      "mask/inner_radius must be less than the mirror's rim, which lens and mirror put at " +
          std::to_string(rimRadiusPx(mirror)) + " px");
  require.between("alignment/centre_stddev", alignment.centre_stddev_px, 0.0, kLargestSide_px);
  const SensorGeometry& geometry = alignment.geometry;
  require.between("alignment/harmonic_stddev", geometry.harmonic_stddev_rad, 0.0, 1.0);
  require.between("alignment/near_per_far", geometry.near_per_far_m, -1.0, 1.0);
  require.between("alignment/nearness_stddev", geometry.nearness_stddev_rad_m, 0.0, 1.0);
  require.between("alignment/elevation_stddev", alignment.elevation_stddev_rad, 0.0, kPi);
  require.between("defocus/sigma", defocus_sigma_px, 0.0, kMaxDefocus_px);
  require.between("gates/max_candidates", max_candidates, 1.0, kMaxCandidates);
  return require.errors();
}

}  // namespace bearing_calibration::core
