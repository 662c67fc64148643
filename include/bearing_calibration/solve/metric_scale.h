#pragma once

#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration::core {

/// An estimate without what its linearisation seems to know of the metric scale. Bearings and wheel
/// readings are the same for a world in which all lengths are so many times larger: mount, lights
/// and the wheels with their separation. So only what was known beforehand tells the scale. But
/// parts of a record that are linearised at slightly different scales seem to tell it together:
/// over hours the scale would drift, and its standard deviation with it would be too small (the
/// observability constraint of Huang, Mourikis and Roumeliotis, 2010; start.md, eq. 9).
/// @param at  where what follows will be linearised
/// @param priors  that the estimate contains
StateEstimate withoutLearntScale(const StateEstimate& estimate, const StateVector& at,
                                 const ErrorPriors& priors);

/// How far the wheels' scales and their separation are from what was known beforehand: chi-square
/// beyond what chance gives one robot in four, 0 below. Of the three, bearings tell the two
/// ratios only (two degrees of freedom).
double doubtOfLengths(const ErrorEstimate& estimate, const ErrorPriors& priors);

/// An estimate for wheels that are farther from what was known beforehand than its standard
/// deviations allow. Which of them is, nobody knows, and so the metric scale is as wrong: what was
/// known counts with a variance that is larger by doubtOfLengths(). The estimate's error then has
/// the covariance P + doubt P L P, with the prior's information L (model.md, eq. 28).
StateEstimate withDoubtOfLengths(StateEstimate estimate, const ErrorPriors& priors);

}  // namespace bearing_calibration::core
