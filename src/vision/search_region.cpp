#include "bearing_calibration/vision/search_region.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

void SearchConfig::declare(Parameters& params) {
  constexpr double kWidest_rad = radiansFromDegrees(89.0);  // a wedge is narrower than a half plane
  constexpr double kFastest_pxps = 1e6;
  params.read("prediction/use", use);
  params.number("prediction/sigmas", sigmas, 0.0, plausible::kMostSigmas);
  params.number("prediction/margin", margin_rad, plausible::kLeastAngle_rad, kPi);
  params.number("prediction/max_half_width", max_half_width_rad, 0.0, kWidest_rad);
  params.number("prediction/max_age", max_age_s, 0.0, plausible::kLongest_s);
  params.number("time/max_turn_rate", max_turn_rate_radps, 0.0, plausible::kFastestTurn_radps);
  params.number("prediction/max_radius_rate", max_radius_rate_pxps, 0.0, kFastest_pxps);
}

std::optional<SeenRadius> seenRadius(const BearingSet& bearings,
                                     const BearingPrediction& prediction) {
  const auto off = [&](const Bearing& candidate) {
    return std::abs(wrapAngle(candidate.azimuth_rad - prediction.azimuth_rad));
  };
  const auto nearest = std::min_element(
      bearings.candidates.begin(), bearings.candidates.end(),
      [&](const Bearing& left, const Bearing& right) { return off(left) < off(right); });
  if (nearest == bearings.candidates.end()) return std::nullopt;
  return SeenRadius{bearings.stamp, nearest->image_radius_px, nearest->image_radius_variance_px2};
}

std::optional<SearchRegion> searchRegion(const SearchConfig& config,
                                         const BearingPrediction& prediction,
                                         const std::optional<SeenRadius>& seen, Stamp stamp) {
  if (!config.use) return std::nullopt;
  const double age_s = std::abs(secondsFromDuration(stamp - prediction.stamp));
  const double half_width_rad = config.sigmas * std::sqrt(prediction.azimuth_variance_rad2) +
                                config.max_turn_rate_radps * age_s;
  const bool useful = std::isfinite(prediction.azimuth_rad) && age_s <= config.max_age_s &&
                      config.margin_rad + half_width_rad <= config.max_half_width_rad;
  if (!useful) return std::nullopt;
  const double azimuth_rad = wrapAngle(prediction.azimuth_rad);
  SearchRegion region{std::nullopt, {azimuth_rad, config.margin_rad + half_width_rad}};
  if (!seen) return region;
  const double unseen_s = std::abs(secondsFromDuration(stamp - seen->stamp));
  if (unseen_s > config.max_age_s) return region;
  const double half_height_px =
      config.sigmas * std::sqrt(seen->radius_variance_px2) + config.max_radius_rate_pxps * unseen_s;
  region.place = ExpectedPlace{{seen->radius_px, azimuth_rad}, half_width_rad, half_height_px};
  return region;
}

cv::Rect boxAround(const ExpectedPlace& place, const ExpectedSpot& expected_spot,
                   const DetectorConfig& config) {
  constexpr double kRim_px = 2.0;
  constexpr double kDisc = 2.0;  // standard deviations to an evenly filled ellipse's outline
  const double radius_px = place.centre.image_radius_px;
  const SpotSize& expected = expected_spot.at(radius_px);
  const Eigen::Vector2d largest = kDisc * expected.pointStddev_px(1.0);
  const double bow = 0.5 * radius_px * place.half_width_rad * place.half_width_rad;  // of an arc
  const double along = place.half_height_px + bow;
  const double across = radius_px * place.half_width_rad;
  const double tangential = largest(0);
  const double radial = largest(1);
  const Eigen::Vector2d centre = imageFromMirrorPixel(config.view, place.centre);
  const double cosine = std::abs(std::cos(place.centre.azimuth_rad));
  const double sine = std::abs(std::sin(place.centre.azimuth_rad));
  const auto half_of = [&](double outward, double sideways) {
    const double r = radial * outward;
    const double t = tangential * sideways;
    return along * outward + across * sideways + std::sqrt(r * r + t * t) + kRim_px;
  };
  const double half_width = half_of(cosine, sine);
  const double half_height = half_of(sine, cosine);
  const auto limited = [](double value, int last) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(last)));
  };
  const ImageSensor& sensor = config.sensor;
  return {cv::Point(limited(centre.x() - half_width, sensor.width_px),
                    limited(centre.y() - half_height, sensor.height_px)),
          cv::Point(limited(centre.x() + half_width + 1.0, sensor.width_px),
                    limited(centre.y() + half_height + 1.0, sensor.height_px))};
}

}  // namespace bearing_calibration::core
