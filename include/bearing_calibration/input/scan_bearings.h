#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// One scan of a laser scanner, its rays in the order in which they were measured.
struct LaserScan {
  Stamp stamp;                   ///< of the first ray
  double ray_period_s = 0.0;     ///< from one ray to the next
  double first_ray_rad = 0.0;    ///< direction of the first ray, counter-clockwise
  double ray_spacing_rad = 0.0;  ///< from one ray to the next; negative: clockwise
  double least_range_m = 0.0;    ///< a range beyond these two, or not finite, is no echo
  double most_range_m = 0.0;
  std::vector<float> ranges_m;
  std::vector<float> intensities;  ///< empty: the scanner has none
};

/// What the light is in a scan: a bright reflector, a post in front of what is behind it, or a
/// bright post. Parameter group `scan`.
struct ScanLightConfig {
  double min_intensity = 0.0;  ///< of a reflector's rays, in the scanner's unit; 0: any
  double min_jump_m = 0.0;     ///< a post is so much nearer than what is beside it; 0: need not be
  double min_width_m = 0.0;    ///< of the reflector or post, as it is seen
  double max_width_m = 0.0;

  void declare(Parameters& params);
};

/// A candidate in a scan, in the scanner's frame.
struct ScanLight {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  ///< the middle of what is seen of it
  Stamp stamp;                                           ///< of the ray in its middle
  int rays = 0;
};

/// Why a scan cannot be used, as a name for counters; empty for one that can.
std::string whyUnusable(const LaserScan& scan, const ScanLightConfig& config);

/// The runs of consecutive rays that may be the light, those of the most rays first. One that
/// reaches the first or the last ray is left out: its middle is not known.
std::vector<ScanLight> lightsInScan(const LaserScan& scan, const ScanLightConfig& config);

/// The directions of its rays, all around where these leave out no more than a ray.
FieldOfView viewOf(const LaserScan& scan);

/// Variance of a middle between two edges that fall anywhere between two rays [rad^2].
double edgeVariance(const LaserScan& scan);

/// Candidates of several moments as one image: it has the stamp of the one that is nearest to where
/// the light is expected, without a recent prediction of the first one; the others get the square
/// of what a turn of the robot may be wrong by added to their variance, as those of a rolling
/// shutter do (vision/light_bearings.h).
struct TimedBearing {
  Bearing bearing;
  Stamp stamp;
};
BearingSet atOneMoment(const std::vector<TimedBearing>& candidates,
                       const std::optional<BearingPrediction>& prediction);

/// What may be the light in a scan, as bearings without elevation in the sensor's frame, and where
/// the scanner sees. Without any of them the stamp is the scan's.
/// @param scan  that whyUnusable() says nothing of
/// @param stddev_rad  of each azimuth, beside that of its edges
BearingSet bearingsInScan(const LaserScan& scan, const ScanLightConfig& config,
                          const Eigen::Isometry3d& sensor_from_scan, double stddev_rad,
                          const std::optional<BearingPrediction>& prediction);

}  // namespace bearing_calibration::core
