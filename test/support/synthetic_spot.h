#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <random>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {
namespace test {

/// An evenly lit elliptical disc on a flat background: what an open aperture makes of a point.
struct SpotDrawing {
  Eigen::Vector2d centre_px;
  double major_angle_rad = 0.0;  ///< of the major axis in (u, v)
  double major_diameter_px = 0.0;
  double minor_diameter_px = 0.0;
  double light_levels = 0.0;  ///< over the background
};

/// Expected levels, integrated over each pixel's square. CV_64FC1.
cv::Mat flatImage(int width_px, int height_px, double background_levels);
void addSpot(cv::Mat* expected_levels, const SpotDrawing& spot);

/// The spot that `config`'s mirror makes of a point light; azimuth in the sensor frame.
SpotDrawing spotOfLight(const DetectorConfig& config, const LightPlace& light, double azimuth_rad,
                        double light_levels);

/// An exposure: photon noise, read noise, rounding, saturation. CV_8UC1.
cv::Mat expose(const cv::Mat& expected_levels, const ImageSensor& sensor, std::mt19937* random);

/// Cramer-Rao bound [rad^2] of the azimuth of `spot`'s centre, with centre, brightness and
/// background unknown and the disc's shape known: the inverse Fisher information of the exposure.
double azimuthBound(const DetectorConfig& config, const SpotDrawing& spot,
                    double background_levels);

/// What config/detection.yaml says of the simulated robot (shipped_values_test holds it).
DetectorConfig shippedDetector();

/// The same for a bright point light and a perfectly known alignment, in an image that is not
/// flipped.
DetectorConfig defaultDetector();

}  // namespace test
}  // namespace bearing_calibration::core
