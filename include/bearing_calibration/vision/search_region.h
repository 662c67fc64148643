#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/annulus_mask.h"

namespace bearing_calibration {

/// How far a prediction of the bearing narrows the search. Parameter group `prediction`.
struct SearchConfig {
  bool use = false;
  double sigmas = 0.0;               ///< half the region's width in the prediction's deviations
  double margin_rad = 0.0;           ///< added on either side: at least the light's own image
  double max_half_width_rad = 0.0;   ///< a wider region is no help: the whole mask is searched
  double max_age_s = 0.0;            ///< an older prediction says nothing
  double max_turn_rate_radps = 0.0;  ///< of the bearing: widens the region with the age

  std::vector<std::string> validate() const;
};

/// The sector in which the light is expected in an image of `stamp`; none without a useful
/// prediction.
std::optional<AzimuthSector> searchRegion(const SearchConfig& config,
                                          const BearingPrediction& prediction, Stamp stamp);

}  // namespace bearing_calibration
