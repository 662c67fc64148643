#include "bearing_calibration/vision/search_region.h"

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
  return require.errors();
}

std::optional<AzimuthSector> searchRegion(const SearchConfig& config,
                                          const BearingPrediction& prediction, Stamp stamp) {
  if (!config.use) return std::nullopt;
  const double age_s = std::abs(secondsFromDuration(stamp - prediction.stamp));
  const double half_width_rad = config.margin_rad +
                                config.sigmas * std::sqrt(prediction.azimuth_variance_rad2) +
                                config.max_turn_rate_radps * age_s;
  const bool useful = std::isfinite(prediction.azimuth_rad) && age_s <= config.max_age_s &&
                      half_width_rad <= config.max_half_width_rad;
  if (!useful) return std::nullopt;
  return AzimuthSector{wrapAngle(prediction.azimuth_rad), half_width_rad};
}

}  // namespace bearing_calibration
