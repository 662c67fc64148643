#include "bearing_calibration/vision/search_region.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration {

std::vector<std::string> SearchConfig::validate() const {
  constexpr double kWidest_rad = radiansFromDegrees(89.0);  // a wedge is narrower than a half plane
  Requirements require;
  require.notNegative("prediction/sigmas", sigmas);
  require.positive("prediction/margin", margin_rad);
  require.between("prediction/max_half_width", max_half_width_rad, 0.0, kWidest_rad);
  require.notNegative("prediction/max_age", max_age_s);
  require.notNegative("prediction/max_turn_rate", max_turn_rate_radps);
  require.notNegative("prediction/max_radius_rate", max_radius_rate_pxps);
  return require.errors();
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

}  // namespace bearing_calibration
