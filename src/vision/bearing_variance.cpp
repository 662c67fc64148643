#include "bearing_calibration/vision/bearing_variance.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
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
// A full pixel on a spot's outline says whether light was there, not how much: what it may be wrong
// by, as a part of a full pixel (a coin's toss would be 0.5; measured on clipped discs and lines).
constexpr double kClippedOutline = 0.26;

/// Read noise and rounding of one pixel [levels^2].
double readVariance(const ImageSensor& sensor) {
  return std::pow(sensor.read_noise_electrons / sensor.electrons_per_level, 2) + kRoundingVariance;
}

/// How much of the white noise's variance a Gaussian blur leaves in each pixel.
double noiseAfterDefocus(double sigma_px) { return 1.0 / (1.0 + 4.0 * kPi * sigma_px * sigma_px); }

/// Variance of the ring's pixels beyond their noise [levels^2].
double textureVariance(const DetectorConfig& config, const SpotMeasurement& spot) {
  const ImageSensor& sensor = config.sensor;
  const double light = std::max(0.0, spot.background.plane.at_centre - sensor.black_level);
  const double noise = light / sensor.electrons_per_level + readVariance(sensor);
  return std::max(
      0.0, spot.background.residual_variance - noise * noiseAfterDefocus(config.defocus_sigma_px));
}

/// The spot as the sensor took it, before any software defocus, as an ellipse of even light.
struct SensedSpot {
  double tangential_variance_px2;
  double radial_variance_px2;
  double area_px;
};

SensedSpot sensedSpot(const DetectorConfig& config, const SpotMeasurement& spot) {
  const double defocus = std::pow(config.defocus_sigma_px, 2);
  const double tangential = std::max(kPixelVariance, spot.tangential.variance_px2 - defocus);
  const double radial = std::max(kPixelVariance, spot.radial.variance_px2 - defocus);
  return {tangential, radial, 4.0 * kPi * std::sqrt(tangential * radial)};
}

/// Of the centre, for a source whose surface is not evenly bright [px^2].
double sourceVariance(const DetectorConfig& config, const AxisSums& sums, double expected_stddev_px,
                      double saturated_fraction) {
  const double expected_variance = expected_stddev_px * expected_stddev_px;
  const double extent =
      std::max(sums.variance_px2 - expected_variance, kUnseenExtent * expected_variance);
  const double unevenness = kUnevenness * config.light.brightness_spread *
                            (1.0 - kEvenedBySaturation * saturated_fraction);
  return unevenness * unevenness * extent;
}

/// Of the centre along an axis with this second moment: the outline's pixels are wrong
/// independently of each other [px^2].
double clippingVariance(const SensedSpot& sensed, double variance_px2, double saturated_fraction) {
  const double outline_px =
      4.0 * kPi * std::sqrt(0.5 * (sensed.tangential_variance_px2 + sensed.radial_variance_px2));
  return saturated_fraction * std::pow(kClippedOutline / sensed.area_px, 2) * outline_px *
         variance_px2;
}

/// Of the centre, for the noise of the pixels and what lies behind the light [px^2].
double pixelVariance(const DetectorConfig& config, const SpotMeasurement& spot,
                     const AxisSums& sums) {
  const ImageSensor& sensor = config.sensor;
  const Background& background = spot.background;
  const double texture = textureVariance(config, spot) * kTexturePatch_px;
  const double reading = readVariance(sensor) * sums.pixel_squares;
  const double slope_variance =
      background.sum_of_squares > 0.0
          ? (background.residual_variance + texture) / background.sum_of_squares
          : 0.0;
  const double behind =
      slope_variance * sums.slope_lever * sums.slope_lever + texture * sums.pixel_squares;
  return (sums.light_noise + reading + behind) / (sums.gain * sums.gain);
}

}  // namespace

LevelNoise levelNoise(const ImageSensor& sensor) {
  return {sensor.black_level, sensor.saturation_level, 1.0 / sensor.electrons_per_level,
          std::pow(sensor.response_spread, 2)};
}

double saturatedFraction(const DetectorConfig& config, const SpotMeasurement& spot) {
  return std::min(1.0, spot.full_pixels / sensedSpot(config, spot).area_px);
}

CentreVariance centreVariance(const DetectorConfig& config, const SpotMeasurement& spot,
                              const SpotSize& expected) {
  const SensedSpot sensed = sensedSpot(config, spot);
  const double saturated = saturatedFraction(config, spot);
  const auto along = [&](const AxisSums& sums, double expected_px, double sensed_variance_px2) {
    return pixelVariance(config, spot, sums) + std::pow(kSamplingStddev_px, 2) +
           sourceVariance(config, sums, expected_px, saturated) +
           clippingVariance(sensed, sensed_variance_px2, saturated);
  };
  return {along(spot.tangential, expected.tangential_stddev_px.low, sensed.tangential_variance_px2),
          along(spot.radial, expected.radial_stddev_px.low, sensed.radial_variance_px2)};
}

Bearing bearingFromPixel(const DetectorConfig& config, const MirrorPixel& centre,
                         const CentreVariance& variance, double probability) {
  const double centre_variance = std::pow(config.alignment.centre_stddev_px, 2);
  Bearing bearing;
  bearing.azimuth_rad = centre.azimuth_rad;
  bearing.azimuth_variance_rad2 =
      variance.tangential_px2 / std::pow(centre.image_radius_px, 2);
  bearing.image_radius_px = centre.image_radius_px;
  bearing.image_radius_variance_px2 = variance.radial_px2 + centre_variance;
  bearing.probability = probability;
  if (!config.gates.mirror) return bearing;  // what the camera looks into is not known
  bearing.elevation_rad = elevationFromRadius(config.mirror, centre.image_radius_px);
  bearing.elevation_variance_rad2 =
      bearing.image_radius_variance_px2 *
          std::pow(elevationSlope(config.mirror, centre.image_radius_px), 2) +
      std::pow(config.alignment.elevation_stddev_rad, 2);
  return bearing;
}

}  // namespace bearing_calibration::core
