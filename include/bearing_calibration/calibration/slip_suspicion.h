#pragma once

#include <vector>

#include "bearing_calibration/calibration/batch_estimator.h"

namespace bearing_calibration {

/// How far the mount moves when smaller suspicions of a slip are followed than the batch did: on a
/// short record a slip can hide in a wrong mount, too small a gain by itself to be declared.
/// @param gain  chi-square (2 degrees of freedom) from which a motion is suspected
/// @returns squared Mahalanobis distance by the covariance of `batch`: near 0 when nothing hides;
///   infinite when the suspicious fit does not settle
double changeByHiddenSlip(const std::vector<Sight>& sights, const BatchEstimate& batch,
                          const BatchConfig& config, double gain);

/// Whether the mount would be another one if smaller suspicions of a slip were followed: then it is
/// not to be trusted yet.
bool hidesSlip(const std::vector<Sight>& sights, const BatchEstimate& batch,
               const BatchConfig& config);

}  // namespace bearing_calibration
