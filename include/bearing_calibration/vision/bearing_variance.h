#pragma once

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"
#include "bearing_calibration/vision/light_ellipse.h"
#include "bearing_calibration/vision/spot_meter.h"

namespace bearing_calibration {

/// Variance of the intensity centroid (doc/detection.md, eq. V1): photon noise, read
/// noise and rounding, the pixels' unequal sensitivities, the background plane, an unevenly bright
/// light, and the texture behind it.
CentreVariance centreVariance(const DetectorConfig& config, const SpotMeasurement& spot,
                              const SpotSize& expected, double saturated_fraction);

/// The ellipse as a bearing: azimuth about the mirror's centre, image radius, and elevation of the
/// ray (NaN when the mirror's gates are off).
/// @param quality 0 to 1, as in LightBearing.msg
Bearing bearingFromEllipse(const DetectorConfig& config, const LightEllipse& ellipse,
                           const CentreVariance& variance, double quality);

}  // namespace bearing_calibration
