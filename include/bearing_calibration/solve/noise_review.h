#pragma once

#include <vector>

#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/noise_levels.h"
#include "bearing_calibration/solve/noise_record.h"

namespace bearing_calibration::core {

/// What a record says when nobody knows its noise.
struct NoiseReview {
  NoiseLevels levels;
  /// At the last observation, over all levels that the record allows: at least as wide as with the
  /// likeliest of them.
  StateEstimate average;
  NoiseInformation told;  ///< by these observations alone, of all unknowns
};

/// The levels that make the innovations of a settled fit most likely, priors and all, beside a
/// correlation of neighbouring bearings that is unknown, too (model.md, eq. 22). What the fit
/// left out stays out. A slip competes with more noise.
/// @param observations  of one light, as stated, those of the fit
/// @param used  the levels with which the fit was made
/// @param told_before  by the observations that have been given away
NoiseReview reviewNoise(const std::vector<Observation>& observations, const BatchEstimate& fit,
                        const ErrorPriors& errors, const NoisePriors& priors,
                        const NoiseLevels& used, const NoiseInformation& told_before = {});

/// An estimate that rests on a fit, moved as the average lies against the fit, and with the
/// covariance that the average has beyond the fit's own.
StateEstimate withItsNoise(StateEstimate estimate, const BatchEstimate& fit,
                           const NoiseReview& review);

}  // namespace bearing_calibration::core
