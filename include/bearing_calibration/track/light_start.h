#pragma once

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {

/// A distance from the sensor to the light, and how well it is known.
struct LightDistance {
  double mean_m = 0.0;
  double stddev_m = 0.0;
};

/// Places the light on the ray of one bearing, seen from a mount that is known to its covariance
/// (model.md, eq. 14). The start of a filter from an earlier mount, and of its light after its
/// track was lost.
CartesianEstimate placeLight(const MountEstimate& base_from_sensor, const LightDistance& distance,
                             double azimuth_rad, double azimuth_variance_rad2);

/// Forgets a part of what is known about the only light, and nothing about the mount: adds a
/// variance of `stddev_m` in every direction and of `stddev_rad` seen from the base across the line
/// of sight.
StateEstimate widenLight(StateEstimate estimate, double stddev_m, double stddev_rad);

}  // namespace bearing_calibration::core
