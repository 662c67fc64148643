#include "bearing_calibration/vision/detector_config.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

using namespace plausible;

namespace {

constexpr double kLargestLevel = 65535.0;  // of a 16-bit image
constexpr double kMaxDefocus_px = 20.0;    // beyond, a light is as wide as the mirror's annulus
constexpr int kMaxCandidates = 1000;
constexpr double kMaxElectrons = 1e9;  // of a pixel
constexpr double kMaxPixels = kLargestSide_px * kLargestSide_px;
constexpr double kLargestLight_m = 10.0;

void declareSensor(Parameters& params, ImageSensor& sensor) {
  params.integer("sensor/width", sensor.width_px, 1.0, kLargestSide_px);
  params.integer("sensor/height", sensor.height_px, 1.0, kLargestSide_px);
  params.number("sensor/electrons_per_level", sensor.electrons_per_level, 1.0 / kLargestLevel,
                kMaxElectrons);
  params.number("sensor/black_level", sensor.black_level, 0.0, kLargestLevel);
  params.number("sensor/saturation_level", sensor.saturation_level, 1.0, kLargestLevel);
  params.that(sensor.black_level < sensor.saturation_level,
              "sensor/black_level must be less than sensor/saturation_level");
  params.number("sensor/read_noise", sensor.read_noise_electrons, 0.0, kMaxElectrons);
  params.number("sensor/response_spread", sensor.response_spread, 0.0, 1.0);
}

/// Where no spot is compared with the optics, they need not be known: those of some cone do.
void standInForOptics(Parameters& params) {
  params.standIn("lens/focal_length", 4e-3);
  params.standIn("lens/aperture", 1.7e-3);
  params.standIn("lens/focus_distance", 0.06);
  params.standIn("lens/pixel_pitch", 5.6e-6);
  params.standIn("mirror/lens_to_apex", 0.08);
  params.standIn("mirror/half_angle", radiansFromDegrees(52.5));
  params.standIn("mirror/base_radius", 0.035);
}

/// Without a mirror none is used; about a centre far aside, axes are those of the image.
void standInForMirror(Parameters& params) {
  params.standIn("mirror/centre_u", -kLargestSide_px);
  params.standIn("mirror/centre_v", 239.5);
  params.standIn("mask/inner_radius", 40.0);
  params.standIn("mask/outer_radius", 250.0);
}

void declareOptics(Parameters& params, OpticsUncertainty& stddev, MirrorView& view) {
  constexpr double kHalf = 0.5;  // beyond, an optics value says nothing
  params.number("lens/scale_stddev", stddev.scale, 0.0, kHalf);
  params.number("lens/aperture_stddev", stddev.aperture, 0.0, kHalf);
  params.number("lens/focus_stddev", stddev.focus, 0.0, kHalf);
  params.number("mirror/half_angle_stddev", stddev.half_angle_rad, 0.0, radiansFromDegrees(10.0));
  params.number("mirror/centre_u", view.centre_u_px, -kLargestSide_px, 2.0 * kLargestSide_px);
  params.number("mirror/centre_v", view.centre_v_px, -kLargestSide_px, 2.0 * kLargestSide_px);
  params.read("mirror/handedness", view.handedness);
  params.that(view.handedness == 1 || view.handedness == -1,
              "mirror/handedness must be 1 or -1, but is " + std::to_string(view.handedness));
}

/// Whether the image, if it is one, has a pixel nearer to the mirror's centre than the mask's end.
bool reachesTheImage(const MaskConfig& mask, const ImageSensor& sensor, const MirrorView& view) {
  const auto outside = [](double place, double first, double last) {
    return place - std::max(first, std::min(place, last));
  };
  return sensor.width_px < 1 || std::hypot(outside(view.centre_u_px, 0.0, sensor.width_px - 1.0),
                                           outside(view.centre_v_px, mask.first_row,
                                                   mask.last_row)) < mask.outer_radius_px;
}

/// @param view  of the mirror, round which the mask lies; null without one
void declareMask(Parameters& params, const ImageSensor& sensor, const MirrorView* view,
                 MaskConfig& mask) {
  params.number("mask/inner_radius", mask.inner_radius_px, 0.0, kLargestSide_px);
  params.number("mask/outer_radius", mask.outer_radius_px, 1.0, kLargestSide_px);
  params.that(mask.inner_radius_px < mask.outer_radius_px,
              "mask/inner_radius must be less than mask/outer_radius");
  params.integer("mask/first_row", mask.first_row, 0.0, kLargestSide_px);
  params.integer("mask/last_row", mask.last_row, 0.0, kLargestSide_px);
  params.that(mask.first_row <= mask.last_row,
              "mask/first_row must not be greater than mask/last_row");
  params.that(mask.last_row < sensor.height_px, "mask/last_row must be less than sensor/height");
  params.that(
      view == nullptr || reachesTheImage(mask, sensor, *view),
      "mask/outer_radius around mirror/centre_u and mirror/centre_v has no pixel of the image");
  params.list("mask/posts", 2, mask.posts, [](const auto& row) {
    return MirrorPost{row[0], row[1]};
  });
  for (const MirrorPost& post : mask.posts) {
    params.between("mask/posts azimuth", post.azimuth_rad, -2.0 * kPi, 2.0 * kPi);
    params.between("mask/posts half width", post.half_width_rad, 0.0, kPi);
  }
}

void declareLight(Parameters& params, const ConicMirror& mirror, LightModel& light) {
  params.number("light/min_distance", light.min_distance_m, kShortest_m, kFarthest_m);
  params.number("light/max_distance", light.max_distance_m, kShortest_m, kFarthest_m);
  // A light inside the mirror's own radius has no path over it.
  params.that(light.min_distance_m > mirror.base_radius_m,
              "light/min_distance must be greater than mirror/base_radius");
  params.that(light.max_distance_m > light.min_distance_m,
              "light/max_distance must be greater than light/min_distance");
  params.number("light/radius", light.radius_m, 0.0, kLargestLight_m);
  params.number("light/min_radius", light.min_radius_m, 0.0, kLargestLight_m);
  params.that(light.min_radius_m <= light.radius_m,
              "light/min_radius must not be greater than light/radius");
  params.number("light/half_height", light.half_height_m, 0.0, kLargestLight_m);
  params.number("light/brightness_spread", light.brightness_spread, 0.0, 1.0);
  params.number("light/max_height", light.max_height_m, 0.0, kFarthest_m);
}

void declareAlignment(Parameters& params, AlignmentConfig& alignment) {
  SensorGeometry& geometry = alignment.geometry;
  params.number("alignment/centre_stddev", alignment.centre_stddev_px, 0.0, kLargestSide_px);
  params.number("alignment/harmonic_stddev", geometry.harmonic_stddev_rad, 0.0, 1.0);
  params.number("alignment/near_per_far", geometry.near_per_far_m, -1.0, 1.0);
  params.number("alignment/nearness_stddev", geometry.nearness_stddev_rad_m, 0.0, 1.0);
  params.number("alignment/elevation_stddev", alignment.elevation_stddev_rad, 0.0, kPi);
}

}  // namespace

void DetectorConfig::declare(Parameters& params) {
  params.choice("mirror/kind", {"cone", "other", "none"}, mirror_kind);
  if (mirror_kind != MirrorKind::kCone) standInForOptics(params);
  if (mirror_kind == MirrorKind::kNone) standInForMirror(params);
  declareSensor(params, sensor);
  mirror.declare(params);
  declareOptics(params, optics_stddev, view);
  declareMask(params, sensor, mirror_kind == MirrorKind::kNone ? nullptr : &view, mask);
  declareLight(params, mirror, light);
  declareAlignment(params, alignment);
  params.number("threshold/min_contrast", threshold.min_contrast_levels, 1.0 / kLargestLevel,
                kLargestLevel);
  params.number("threshold/spreads", threshold.spreads, 0.0, kMostSigmas);
  params.integer("gates/max_pixels", gates.max_pixels, 1.0, kMaxPixels);
  params.integer("gates/min_pixels", gates.min_pixels, 1.0, kMaxPixels);
  params.that(gates.min_pixels <= gates.max_pixels,
              "gates/min_pixels must not be greater than gates/max_pixels");
  params.number("gates/min_probability", gates.min_probability, 0.0, 1.0);
  params.integer("gates/max_candidates", max_candidates, 1.0, kMaxCandidates);
  params.number("defocus/sigma", defocus_sigma_px, 0.0, kMaxDefocus_px);
  params.that(
      mirror_kind != MirrorKind::kCone || !errorsOf(mirror).empty() ||
          mask.inner_radius_px < rimRadiusPx(mirror),
      "mask/inner_radius must be less than the mirror's rim, which lens and mirror put at " +
          std::to_string(rimRadiusPx(mirror)) + " px");
}

}  // namespace bearing_calibration::core
