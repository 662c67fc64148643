#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/optics/camera.h"
#include "bearing_calibration/optics/conic_mirror.h"

namespace bearing_calibration::core {

/// What the camera looks into, in the order of its names.
enum class MirrorKind : std::uint8_t {
  kCone,   ///< spots are compared with what it makes of a light
  kOther,  ///< they are not; the azimuth is that about the mirror's centre, too
  kNone,   ///< a lens alone: a spot's direction is that of its ray, spots are not compared
};

/// A holder that hides a sector of the mirror. A light of radius a at distance D is disturbed
/// a / D further to either side: let the half width include that and about a degree.
struct MirrorPost {
  double azimuth_rad = 0.0;
  double half_width_rad = 0.0;
};

/// The part of the image in which a light may be seen. Parameter group `mask`.
struct MaskConfig {
  double inner_radius_px = 0.0;  ///< inside, the camera sees itself
  double outer_radius_px = 0.0;
  int first_row = 0;
  int last_row = 0;  ///< included
  std::vector<MirrorPost> posts;
};

/// The image sensor. Levels are units of the grey image. Parameter group `sensor`.
struct ImageSensor {
  int width_px = 0;
  int height_px = 0;
  double electrons_per_level = 0.0;
  double black_level = 0.0;       ///< what darkness reads
  double saturation_level = 0.0;  ///< from this level on a pixel is full
  double read_noise_electrons = 0.0;
  double response_spread = 0.0;  ///< relative standard deviation of the pixels' sensitivities
};

/// What separates a light from the background. Parameter group `threshold`.
struct ThresholdConfig {
  double min_contrast_levels = 0.0;  ///< at least so far above the background's median
  double spreads = 0.0;              ///< and at least so many of its spreads (robust sigmas)
};

/// What is known of the light. Parameter group `light`.
struct LightModel {
  double min_distance_m = 0.0;  ///< horizontal, from the mirror's axis
  double max_distance_m = 0.0;
  double min_radius_m = 0.0;       ///< of the glowing surface around its middle, 0 for a point
  double radius_m = 0.0;           ///< the same at most
  double half_height_m = 0.0;      ///< of that surface above and below its middle
  double brightness_spread = 0.0;  ///< relative, over that surface
  double max_height_m = 0.0;       ///< over the apex: how far outside of the horizon it may be seen
};

/// How well the optics are known: standard deviations. Parameter groups `lens` and `mirror`.
struct OpticsUncertainty {
  double scale = 0.0;     ///< relative, of the focal length in pixels
  double aperture = 0.0;  ///< relative
  double focus = 0.0;     ///< relative, of the focus distance
  double half_angle_rad = 0.0;
};

/// What a candidate must fulfil. Parameter group `gates`.
struct GateConfig {
  int min_pixels = 0;  ///< of the thresholded spot
  int max_pixels = 0;
  double min_probability = 0.0;  ///< of being a light
};

/// Errors that no single image shows. Parameter group `alignment`.
struct AlignmentConfig {
  SensorGeometry geometry;            ///< what lean, offset and centre do to azimuths
  double centre_stddev_px = 0.0;      ///< of the mirror's centre in the image
  double elevation_stddev_rad = 0.0;  ///< floor of the elevation: the mirror's angle
};

/// Everything that the light detector needs to know; the values worth running with stand in
/// config/detection.yaml.
struct DetectorConfig {
  MirrorKind mirror_kind = MirrorKind::kCone;
  std::optional<Camera> camera;  ///< without a mirror; no parameter, its driver knows it
  ImageSensor sensor;
  ConicMirror mirror;
  OpticsUncertainty optics_stddev;
  MirrorView view;
  MaskConfig mask;
  ThresholdConfig threshold;
  LightModel light;
  GateConfig gates;
  AlignmentConfig alignment;
  double defocus_sigma_px = 0.0;  ///< Gaussian blur of a sharp image before detection; 0 is off
  int max_candidates = 0;         ///< spots that are measured in one image

  void declare(Parameters& params);
};

}  // namespace bearing_calibration::core
