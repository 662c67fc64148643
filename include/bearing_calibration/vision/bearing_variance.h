#pragma once

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"
#include "bearing_calibration/vision/light_ellipse.h"
#include "bearing_calibration/vision/spot_meter.h"

namespace bearing_calibration::core {

/// The part of a pixel's noise that grows with what it sees.
LevelNoise levelNoise(const ImageSensor& sensor);

/// The part of the spot's pixels that are full, by its size on the sensor.
double saturatedFraction(const DetectorConfig& config, const SpotMeasurement& spot);

/// Variance of the spot's centre (doc/detection.md, V1): photon noise, read noise and rounding, the
/// pixels' unequal sensitivities, the background plane and its texture, an unevenly bright light,
/// sampling and clipping of the outline.
CentreVariance centreVariance(const DetectorConfig& config, const SpotMeasurement& spot,
                              const SpotSize& expected);

/// The spot's centre as a bearing: azimuth about the mirror's centre, image radius, and elevation
/// of the ray (NaN when the mirror's gates are off).
/// @param probability 0 to 1, as in LightBearing.msg
Bearing bearingFromPixel(const DetectorConfig& config, const MirrorPixel& centre,
                         const CentreVariance& variance, double probability);

}  // namespace bearing_calibration::core
