#include "bearing_calibration/vision/light_bearings.h"

#include <cmath>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

double rowOf(const Detection& light) { return light.ellipse.centre_px.y(); }

}  // namespace

void ShutterConfig::declare(Parameters& params) {
  constexpr double kLongest_s = 10.0;  // no camera is later; a larger value is in milliseconds
  params.number("time/stamp_to_mid_exposure", stamp_to_mid_exposure_s, -kLongest_s, kLongest_s);
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

std::vector<double> brightnessOf(const std::vector<Detection>& lights) {
  std::vector<double> brightness;
  for (const Detection& light : lights) brightness.push_back(light.ellipse.mass_levels);
  return brightness;
}

}  // namespace bearing_calibration::core
