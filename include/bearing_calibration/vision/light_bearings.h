#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

/// A measured spot as a bearing, without its probability: azimuth about the mirror's centre, image
/// radius, and the elevation of the ray where a spot is expected. The variance of the spot's centre
/// is that of detection.md, V1: photon noise, read noise and rounding, the pixels' unequal
/// sensitivities, the background plane and its texture, an unevenly bright light, sampling and
/// clipping of the outline; and what the search adds, which found it beside a bright area or inside
/// of one of the spots that a lower threshold showed and that were refused.
/// @param expected  null where nothing is
/// Without a mirror: azimuth and elevation of its ray; nothing beyond what the lens shows.
std::optional<Bearing> bearingOf(const LightEllipse& light, const Search& search,
                                 const std::vector<Detection>& refused,
                                 const ExpectedSpot* expected, const DetectorConfig& config);

/// The one of the highest probability; null without any.
const Detection* likeliestLight(const std::vector<Detection>& lights);

/// When the rows of an image were exposed. Parameter group `time`.
struct ShutterConfig {
  double stamp_to_mid_exposure_s = 0.0;  ///< of the first row; negative when stamped at read-out
  double row_time_s = 0.0;               ///< from one row's exposure to the next one's; 0: global
  /// Fastest change of a bearing: how wrong a candidate may be whose row was exposed at another
  /// moment than the stamp says [rad/s].
  double max_turn_rate_radps = 0.0;

  void declare(Parameters& params);
};

/// Mid-exposure of a row (fractions are allowed).
Stamp midExposure(const ShutterConfig& config, Stamp image_stamp, double row);

/// The lights of an image as bearings of one moment: the mid-exposure of the row of the likeliest
/// one (of the image's middle row when there is none). The others, whose rows were exposed a little
/// earlier or later, get (max_turn_rate * that time)^2 added to their azimuth's variance.
BearingSet bearingsFromLights(const std::vector<Detection>& lights, const ShutterConfig& config,
                              Stamp image_stamp, int image_height_px);

/// Whether a prediction is of the moment of an image: an older one says nothing of where the light
/// is by then.
bool isOfMoment(const BearingPrediction& prediction, Stamp stamp);

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
