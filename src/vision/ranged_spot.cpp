#include "bearing_calibration/vision/ranged_spot.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"

namespace bearing_calibration::core {

std::optional<RangedSpot> rangedSpot(const std::vector<Detection>& lights,
                                     const BearingSet& bearings,
                                     const BearingPrediction& prediction) {
  constexpr double kMostAge_s = 0.2;
  constexpr double kSectorSigmas = 4.0;
  constexpr double kBearing_rad = radiansFromDegrees(1.0);  // what the bearings' own noise is below
  constexpr double kLeastKnown = 0.05;                      // of the distance
  constexpr double kMostSaturated = 0.25;  // of the spot's pixels: more make it larger
  const bool known = prediction.distance_variance_m2 <=
                     std::pow(kLeastKnown * prediction.distance_m, 2);  // false of NaN
  const double age_s = std::abs(secondsFromDuration(bearings.stamp - prediction.stamp));
  if (!known || age_s > kMostAge_s) return std::nullopt;
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
