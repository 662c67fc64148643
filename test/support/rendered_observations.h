#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {
namespace test {

/// The default rig, ray-traced finely enough that the spot is smooth.
RendererConfig renderedRig();

/// The detector's configuration for it, its alignment perfectly known.
DetectorConfig detectorOf(const RendererConfig& rendered);

/// A steady wall behind the light.
double plainWall(double azimuth_rad, double elevation_rad);

/// A light at a distance, and the sensor that sees it at an azimuth. Its brightness makes up for
/// the distance, as an exposure control does.
struct Observation {
  double distance_m = 0.0;
  double azimuth_rad = 0.0;
  double brightness = 1.0;  ///< times what gives the renderer's reference value
  double radius_m = 0.0;    ///< of the light

  Light light() const;
  Pose2 worldFromSensor() const;
};

/// Azimuths all around, distances of 0.5 to 5 m evenly in their logarithm.
std::vector<Observation> randomObservations(int count, double brightness, unsigned seed);

/// Azimuths all around at one distance.
std::vector<Observation> observationsAt(double distance_m, int count, double brightness,
                                        unsigned seed);

/// Errors of a series of bearings.
struct BearingErrors {
  int found = 0;
  double sum_rad = 0.0;
  double sum_square_rad2 = 0.0;
  double sum_nees = 0.0;
  double sum_variance_rad2 = 0.0;  ///< as the bearings say of themselves

  void add(const Bearing& bearing, double true_azimuth_rad);
  double rmse_deg() const;
  double bias_deg() const;
  double predicted_deg() const;  ///< root of the mean variance
  double nees() const { return sum_nees / found; }
};

/// Cramer-Rao bound [rad^2] of the azimuth from the rendered image itself, with the light's
/// distance and brightness unknown: the inverse Fisher information of the exposure.
double azimuthBound(ImageRenderer* renderer, const ImageSensor& sensor,
                    const Observation& observation);

}  // namespace test
}  // namespace bearing_calibration::core
