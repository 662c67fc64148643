#pragma once

#include "bearing_calibration/filter/paper_state.h"

namespace bearing_calibration::core {

/// Squared Mahalanobis distance of two independent estimates of one mount: chi-square with 3
/// degrees of freedom when both are honest.
double disagreement(const MountEstimate& a, const MountEstimate& b);

}  // namespace bearing_calibration::core
