#pragma once

#include "bearing_calibration/filter/cartesian_state.h"
#include "bearing_calibration/filter/paper_state.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration {

/// Squared Mahalanobis distance of two independent estimates of one mount: chi-square with 3
/// degrees of freedom when both are honest.
double disagreement(const MountEstimate& a, const MountEstimate& b);

/// An estimate together with what is known of the mount from elsewhere, independently.
RobotEstimate withKnownMount(const RobotEstimate& estimate, const MountEstimate& known);

}  // namespace bearing_calibration
