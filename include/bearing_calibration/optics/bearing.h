#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/optics/field_of_view.h"

namespace bearing_calibration::core {

inline constexpr std::int32_t kUnknownLight = -1;

/// A light's angle over a sensor's x-y plane.
struct Elevation {
  double angle_rad = 0.0;
  double variance_rad2 = 0.0;  ///< > 0
};

/// One candidate for the light in the frame of a bearing sensor: where vision ends and the filter
/// begins. NaN where the sensor has no such value.
struct Bearing {
  double azimuth_rad = 0.0;            ///< counter-clockwise about the sensor's z axis
  double azimuth_variance_rad2 = 0.0;  ///< > 0
  double image_radius_px = std::numeric_limits<double>::quiet_NaN();
  double image_radius_variance_px2 = std::numeric_limits<double>::quiet_NaN();
  double elevation_rad = std::numeric_limits<double>::quiet_NaN();
  double elevation_variance_rad2 = std::numeric_limits<double>::quiet_NaN();  ///< or 0: has none
  std::int32_t light_id = kUnknownLight;
  double probability = 1.0;  ///< 0 to 1, the sensor's own that this is the light, by one image
  /// The same by all images in which the sensor has followed it; or 0: it follows nothing.
  double track_probability = std::numeric_limits<double>::quiet_NaN();

  /// What counts: the track's where it is said, else the image's.
  double overallProbability() const {
    return track_probability > 0.0 ? track_probability : probability;
  }
};

/// The elevation of a bearing that has one: both numbers finite, the variance positive.
inline std::optional<Elevation> elevationOf(const Bearing& bearing) {
  const Elevation elevation{bearing.elevation_rad, bearing.elevation_variance_rad2};
  const bool is_one = std::isfinite(elevation.angle_rad) &&
                      std::isfinite(elevation.variance_rad2) && elevation.variance_rad2 > 0.0;
  return is_one ? std::optional<Elevation>(elevation) : std::nullopt;
}

/// How well a sensor knows its own geometry: what bends all its azimuths alike, by a first harmonic
/// that is larger for near lights (model.md, eq. 19). Zero: there is nothing to know.
struct SensorGeometry {
  double harmonic_stddev_rad = 0.0;  ///< of the harmonic's cosine and sine, for a far light
  double near_per_far_m = 0.0;       ///< over the range: times so much it is larger for a near one
  double nearness_stddev_rad_m = 0.0;  ///< over the range: what a near light may show beyond that

  /// What the law leaves out [rad]: a mirror follows it to some percent (mirror_misalignment_test).
  double unmodelledStddev() const { return 0.03 * harmonic_stddev_rad; }
};

/// All candidates of one image; none says that the sensor looked and saw nothing.
struct BearingSet {
  Stamp stamp;  ///< mid-exposure
  std::vector<Bearing> candidates;
  SensorGeometry geometry = {};  ///< the same in every image of a sensor
  FieldOfView view = {};         ///< ... and this
};

/// Where the calibration expects the light at a moment.
struct BearingPrediction {
  Stamp stamp;
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;  ///< of the prediction alone, without a measurement's noise
  std::int32_t light_id = kUnknownLight;
  double distance_m = std::numeric_limits<double>::quiet_NaN();  ///< of the light; NaN: not known
  double distance_variance_m2 = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace bearing_calibration::core
