#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/noise/noise_search.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {

/// What a record says when nobody knows its noise.
struct NoiseReview {
  NoiseUnknowns likeliest;
  NoiseUnknownsMatrix covariance;
  NoiseLevels levels;     ///< the same, as factors
  double cost;            ///< of the record with them: minus the logarithm of its likelihood
  bool gives_up_slips;    ///< else the motions of the fit's slips are as good as all others
  StateEstimate average;  ///< averageAfter() all observations
  NoiseInformation told;  ///< by these observations alone, of all unknowns
};

/// The levels that make the innovations of a settled fit most likely, priors and all, beside a
/// correlation of neighbouring bearings that is unknown, too (model.md, eq. 22). What the fit
/// left out stays out. A slip competes with more noise.
/// @param observations  of one light, as stated, those of the fit
/// @param start  where the search begins
/// @param told_before  by the observations that have been given away
/// @return none where the fit explains so little that no levels can be weighed
std::optional<NoiseReview> reviewNoise(const std::vector<Observation>& observations,
                                       const BatchEstimate& fit, const ErrorPriors& errors,
                                       const NoisePriors& priors, const NoiseUnknowns& start,
                                       const NoiseInformation& told_before = {});

/// What a fit says after so many observations, over all levels that a review of the same ones
/// allows: at least as wide as with the likeliest of them.
StateEstimate averageAfter(std::size_t count, const std::vector<Observation>& observations,
                           const BatchEstimate& fit, const ErrorPriors& errors,
                           const NoiseReview& review);

}  // namespace bearing_calibration::core
