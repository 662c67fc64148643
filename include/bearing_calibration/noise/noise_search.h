#pragma once

#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/noise/noise_record.h"

namespace bearing_calibration::core {

/// Where the search for the unknowns begins when these levels were the last ones.
NoiseUnknowns unknownsWith(const NoiseLevels& levels);

/// The levels that are likeliest under one supposition about slips.
struct LikeliestNoise {
  NoiseUnknowns unknowns;
  NoiseUnknownsMatrix covariance;
  double cost;            ///< minus the logarithm of the likelihood
  NoiseInformation told;  ///< by the innovations alone
};

/// Searches them from a start by Fisher's scoring (model.md, eq. 22).
/// @param told_before  by the observations that have been given away
/// @param least_log_bearing  lower limit of that unknown
LikeliestNoise findNoise(const NoiseRecord& record, const NoisePriors& priors,
                         const NoiseInformation& told_before, double least_log_bearing,
                         bool gives_up_slips, const NoiseUnknowns& start);

}  // namespace bearing_calibration::core
