#include "bearing_calibration/vision/light_bearings.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/vision/light_detector.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Array2d;  // (tangential, radial)
using Eigen::Vector2d;

// An unevenly lit source moves the centroid by about half of its relative unevenness times its own
// extent; where it is full it looks even (both measured on rings of unequal LEDs by ray trace).
constexpr double kUnevenness = 0.55;
constexpr double kEvenedBySaturation = 0.6;
// Of the variance of the spot that may be the source's own when none is seen: the measured size is
// as uncertain as that.
constexpr double kUnseenExtent = 0.04;
// The sharp outline of a disc falls between pixels: in random places this moves its centre so much
// (noise-free discs of 11 x 20 px, either weight).
constexpr double kSamplingStddev_px = 0.001;
// A full pixel on a spot's outline says whether light was there, not how much: what it may be wrong
// by, as a part of a full pixel (a coin's toss would be 0.5; measured on clipped discs and lines).
constexpr double kClippedOutline = 0.26;
// By which the centre is off where a bright area beside the light was taken away: 0.02 to 0.16 px
// in cluttered scenes (detection.md), 0.8 px where the area covers a pixel of the light's rim.
constexpr double kOpened_px = 0.3;

/// Of the centre, for a source whose surface is not evenly bright, beside a point's image [px^2].
Array2d sourceVariance(const DetectorConfig& config, const LightEllipse& light,
                       const Array2d& point_px) {
  const Array2d extent_px2 =
      (light.variances_px2().array() - point_px.square()).max(kUnseenExtent * point_px.square());
  const double unevenness = kUnevenness * config.light.brightness_spread *
                            (1.0 - kEvenedBySaturation * light.saturated_fraction);
  return unevenness * unevenness * extent_px2;
}

/// Of the centre: the outline's pixels are wrong independently of each other [px^2].
Array2d clippingVariance(const DetectorConfig& config, const LightEllipse& light) {
  const Array2d sensed_px2 = light.sensedVariances_px2(config.defocus_sigma_px);
  const double outline_px = 4.0 * kPi * std::sqrt(sensed_px2.mean());
  const double area_px = 4.0 * kPi * std::sqrt(sensed_px2.prod());
  return light.saturated_fraction * std::pow(kClippedOutline / area_px, 2) * outline_px *
         sensed_px2;
}

/// Whether a spot so refused may be a light all the same. How large a light is, only a mirror says.
bool mayBeLight(Rejection rejection, bool any_size) {
  return (any_size && rejection == Rejection::kTooManyPixels) || rejection == Rejection::kFill ||
         rejection == Rejection::kKurtosis || rejection == Rejection::kTangentialSize ||
         rejection == Rejection::kRadialSize || rejection == Rejection::kAxis ||
         rejection == Rejection::kUnlikely;
}

/// By which the centre of a light is off beside a bright area, and if it is a part of one of these
/// spots and that is the light, unevenly lit: which of both is true, no image tells [px^2].
Array2d searchVariance(const LightEllipse& light, const Search& search,
                       const std::vector<Detection>& refused, bool any_size,
                       const MirrorView& view) {
  constexpr double kDisc2 = 4.0;  // squared standard deviations to the outline
  Array2d variance_px2 = Array2d::Constant(search.opened ? kOpened_px * kOpened_px : 0.0);
  if (search.thresholds == 1) return variance_px2;
  const Eigen::Matrix2d axes = mirrorAxes(light.centre_px, view.centre_px());
  for (const Detection& spot : refused) {
    if (!mayBeLight(spot.rejection, any_size)) continue;
    const Vector2d off_px2 =
        (axes.transpose() * (spot.ellipse.centre_px - light.centre_px)).cwiseAbs2();
    const double mahalanobis2 = off_px2.cwiseQuotient(spot.ellipse.variances_px2()).sum();
    if (mahalanobis2 <= kDisc2) variance_px2 += off_px2.array();
  }
  return variance_px2;
}

/// @param variance_px2  of the light's centre (tangential, radial)
std::optional<Bearing> bearingOfRay(const LightEllipse& light, const Array2d& variance_px2,
                                    const DetectorConfig& config) {
  const std::optional<Direction> direction = directionFromPixel(*config.camera, light.centre_px);
  if (!direction) return std::nullopt;
  const Eigen::Matrix2d J_direction_axes =
      direction->J_direction_pixel * mirrorAxes(light.centre_px, config.view.centre_px());
  const Vector2d variance_rad2 = J_direction_axes.cwiseAbs2() * variance_px2.matrix();
  Bearing bearing;
  bearing.azimuth_rad = direction->azimuth_rad;
  bearing.azimuth_variance_rad2 = variance_rad2(0);
  bearing.elevation_rad = direction->elevation_rad;
  bearing.elevation_variance_rad2 =
      variance_rad2(1) + std::pow(config.alignment.elevation_stddev_rad, 2);
  return bearing;
}

double rowOf(const Detection& light) { return light.ellipse.centre_px.y(); }

}  // namespace

std::optional<Bearing> bearingOf(const LightEllipse& light, const Search& search,
                                 const std::vector<Detection>& refused,
                                 const ExpectedSpot* expected, const DetectorConfig& config) {
  Vector2d point_px = Vector2d::Zero();
  if (expected != nullptr) point_px = expected->at(light.centre_px).least_stddev_px;
  const Array2d variance_px2 =
      light.noise_px2.array() + std::pow(kSamplingStddev_px, 2) +
      sourceVariance(config, light, point_px) + clippingVariance(config, light) +
      searchVariance(light, search, refused, expected == nullptr, config.view);
  if (config.camera) return bearingOfRay(light, variance_px2, config);
  const auto [radius_px, azimuth_rad] =
      mirrorPixelFromImage(config.view, light.centre_px.x(), light.centre_px.y());
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad;
  bearing.azimuth_variance_rad2 = variance_px2(0) / std::pow(radius_px, 2);
  bearing.image_radius_px = radius_px;
  bearing.image_radius_variance_px2 =
      variance_px2(1) + std::pow(config.alignment.centre_stddev_px, 2);
  if (expected == nullptr) return bearing;
  const double slope = elevationSlope(config.mirror, radius_px);
  bearing.elevation_rad = elevationFromRadius(config.mirror, radius_px);
  bearing.elevation_variance_rad2 = bearing.image_radius_variance_px2 * slope * slope +
                                    std::pow(config.alignment.elevation_stddev_rad, 2);
  return bearing;
}

const Detection* likeliestLight(const std::vector<Detection>& lights) {
  const auto best = std::max_element(lights.begin(), lights.end(),
                                     [](const Detection& left, const Detection& right) {
                                       return left.bearing.probability < right.bearing.probability;
                                     });
  return best == lights.end() ? nullptr : &*best;
}

void ShutterConfig::declare(Parameters& params) {
  constexpr double kLatest_s = 10.0;  // no camera is later; a larger value is in milliseconds
  params.number("time/stamp_to_mid_exposure", stamp_to_mid_exposure_s, -kLatest_s, kLatest_s);
  params.number("time/row_time", row_time_s, -1.0, 1.0);
  params.number("time/max_turn_rate", max_turn_rate_radps, 0.0, plausible::kFastestTurn_radps);
}

Stamp midExposure(const ShutterConfig& config, Stamp image_stamp, double row) {
  return image_stamp +
         durationFromSeconds(config.stamp_to_mid_exposure_s + row * config.row_time_s);
}

BearingSet bearingsFromLights(const std::vector<Detection>& lights, const ShutterConfig& config,
                              Stamp image_stamp, int image_height_px) {
  BearingSet set;
  if (lights.empty()) {
    set.stamp = midExposure(config, image_stamp, 0.5 * (image_height_px - 1));
    return set;
  }
  const Detection* likeliest = likeliestLight(lights);
  set.stamp = midExposure(config, image_stamp, rowOf(*likeliest));
  for (const Detection& light : lights) {
    const double apart_s = (rowOf(light) - rowOf(*likeliest)) * config.row_time_s;
    set.candidates.push_back(light.bearing);
    set.candidates.back().azimuth_variance_rad2 +=
        std::pow(config.max_turn_rate_radps * apart_s, 2);
  }
  return set;
}

bool isOfMoment(const BearingPrediction& prediction, Stamp stamp) {
  constexpr double kMostAge_s = 0.2;
  return std::abs(secondsFromDuration(stamp - prediction.stamp)) <= kMostAge_s;
}

std::optional<RangedSpot> rangedSpot(const std::vector<Detection>& lights,
                                     const BearingSet& bearings,
                                     const BearingPrediction& prediction) {
  constexpr double kSectorSigmas = 4.0;
  constexpr double kBearing_rad = radiansFromDegrees(1.0);  // what the bearings' own noise is below
  constexpr double kLeastKnown = 0.05;                      // of the distance
  constexpr double kMostSaturated = 0.25;  // of the spot's pixels: more make it larger
  const bool known = prediction.distance_variance_m2 <=
                     std::pow(kLeastKnown * prediction.distance_m, 2);  // false of NaN
  if (!known || !isOfMoment(prediction, bearings.stamp)) return std::nullopt;
  const double near_rad =
      kBearing_rad + kSectorSigmas * std::sqrt(prediction.azimuth_variance_rad2);
  const Detection* light = nullptr;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Bearing& bearing = bearings.candidates[i];
    const bool is_there =
        std::abs(wrapAngle(bearing.azimuth_rad - prediction.azimuth_rad)) <= near_rad;
    if (!is_there || bearing.probability < LightDetector::kLikely) continue;
    if (light != nullptr) return std::nullopt;
    light = &lights[i];
  }
  if (light == nullptr || light->ellipse.saturated_fraction > kMostSaturated) return std::nullopt;
  return RangedSpot{bearings.stamp,
                    light->bearing.azimuth_rad,
                    light->bearing.image_radius_px,
                    light->ellipse.variances_px2(),
                    prediction.distance_m,
                    prediction.distance_variance_m2};
}

}  // namespace bearing_calibration::core
