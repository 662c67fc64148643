#include "bearing_calibration/vision/bearing_variance.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

constexpr double kRoundingVariance = 1.0 / 12.0;  // of a level rounded to an integer

// An unevenly lit source moves the centroid by about half of its relative unevenness times its own
// extent; where it is full it looks even (both measured on rings of unequal LEDs by ray trace).
constexpr double kUnevenness = 0.55;
constexpr double kEvenedBySaturation = 0.6;
// Of the variance of the spot that may be the source's own when none is seen: the measured size is
// as uncertain as that.
constexpr double kUnseenExtent = 0.04;
// Neighbouring pixels of a background's texture vary together, over patches of about 3 x 3.
constexpr double kTexturePatch_px = 9.0;
// The sharp outline of a disc falls between pixels: in random places this moves its centre so much
// (noise-free discs of 11 x 20 px, either weight).
constexpr double kSamplingStddev_px = 0.001;
// A clipped spot's outline is known to this part of a pixel's own deviation, all errors together.
constexpr double kClippingStddev_px = 0.05;

/// Read noise and rounding of one pixel [levels^2].
double readVariance(const ImageSensor& sensor) {
  return std::pow(sensor.read_noise_electrons / sensor.electrons_per_level, 2) + kRoundingVariance;
}

/// How much of the white noise's variance a Gaussian blur leaves in each pixel.
double noiseAfterDefocus(double sigma_px) { return 1.0 / (1.0 + 4.0 * kPi * sigma_px * sigma_px); }

/// Variance of the ring's pixels beyond their noise [levels^2].
double textureVariance(const DetectorConfig& config, const SpotMeasurement& spot) {
  const ImageSensor& sensor = config.sensor;
  const double light = std::max(0.0, spot.background.at_centre - sensor.black_level);
  const double noise = light / sensor.electrons_per_level + readVariance(sensor);
  return std::max(
      0.0, spot.background.residual_variance - noise * noiseAfterDefocus(config.defocus_sigma_px));
}

/// Of the centroid, for a source whose surface is not evenly bright [px^2].
double sourceVariance(const DetectorConfig& config, const AxisSums& sums, double expected_stddev_px,
                      double saturated_fraction) {
  const double expected_variance = expected_stddev_px * expected_stddev_px;
  const double extent =
      std::max(sums.variance_px2 - expected_variance, kUnseenExtent * expected_variance);
  const double unevenness = kUnevenness * config.light.brightness_spread *
                            (1.0 - kEvenedBySaturation * saturated_fraction);
  return unevenness * unevenness * extent;
}

double axisVariance(const DetectorConfig& config, const SpotMeasurement& spot, const AxisSums& sums,
                    double expected_stddev_px, double saturated_fraction) {
  const ImageSensor& sensor = config.sensor;
  const BackgroundPlane& plane = spot.background;
  const double texture = textureVariance(config, spot) * kTexturePatch_px;
  const double photons = sums.light_squares / sensor.electrons_per_level;
  const double reading = readVariance(sensor) * sums.pixel_squares;
  const double response = std::pow(sensor.response_spread, 2) * sums.intensity_squares;
  const double slope_variance =
      plane.sum_of_squares > 0.0 ? (plane.residual_variance + texture) / plane.sum_of_squares : 0.0;
  const double background =
      slope_variance * sums.slope_lever * sums.slope_lever + texture * sums.pixel_squares;
  return (photons + reading + response + background) / (sums.gain * sums.gain) +
         sourceVariance(config, sums, expected_stddev_px, saturated_fraction) +
         std::pow(kSamplingStddev_px, 2) + std::pow(kClippingStddev_px * saturated_fraction, 2);
}

}  // namespace

CentreVariance centreVariance(const DetectorConfig& config, const SpotMeasurement& spot,
                              const SpotSize& expected, double saturated_fraction) {
  return {
      axisVariance(config, spot, spot.tangential, expected.tangential_stddev_px.low,
                   saturated_fraction),
      axisVariance(config, spot, spot.radial, expected.radial_stddev_px.low, saturated_fraction)};
}

Bearing bearingFromEllipse(const DetectorConfig& config, const LightEllipse& ellipse,
                           const CentreVariance& variance, double quality) {
  const MirrorPixel pixel =
      mirrorPixelFromImage(config.view, ellipse.centre_px.x(), ellipse.centre_px.y());
  const double centre_variance = std::pow(config.alignment.centre_stddev_px, 2);
  Bearing bearing;
  bearing.azimuth_rad = pixel.azimuth_rad;
  bearing.azimuth_variance_rad2 =
      (variance.tangential_px2 + centre_variance) / std::pow(pixel.image_radius_px, 2) +
      std::pow(config.alignment.azimuth_stddev_rad, 2);
  bearing.image_radius_px = pixel.image_radius_px;
  bearing.image_radius_variance_px2 = variance.radial_px2 + centre_variance;
  bearing.quality = quality;
  if (!config.gates.mirror) return bearing;  // what the camera looks into is not known
  bearing.elevation_rad = elevationFromRadius(config.mirror, pixel.image_radius_px);
  bearing.elevation_variance_rad2 =
      bearing.image_radius_variance_px2 *
          std::pow(elevationSlope(config.mirror, pixel.image_radius_px), 2) +
      std::pow(config.alignment.elevation_stddev_rad, 2);
  return bearing;
}

}  // namespace bearing_calibration
