#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detection.h"

namespace bearing_calibration::core {

/// The image of a light of which the distance is known otherwise.
struct RangedSpot {
  Stamp stamp;
  double azimuth_rad = 0.0;
  double image_radius_px = 0.0;
  Eigen::Vector2d variances_px2 = Eigen::Vector2d::Zero();  ///< of the spot: (tangential, radial)
  double distance_m = 0.0;                                  ///< horizontal, from the mirror's axis
  double distance_variance_m2 = 0.0;
};

/// The light that the calibration expects, where it is the only likely one there, stands alone in
/// the image, and its distance is known well enough.
/// @param lights  of the image, as the candidates of `bearings`
std::optional<RangedSpot> rangedSpot(const std::vector<Detection>& lights,
                                     const BearingSet& bearings,
                                     const BearingPrediction& prediction);

}  // namespace bearing_calibration::core
