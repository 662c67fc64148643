#pragma once

#include <Eigen/Core>
#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"

namespace bearing_calibration {

/// The record as it would be if the wheels had rolled `wheels_from_wheels` times what they
/// said: a matrix that maps (left, right) to (left, right). Exact for a motion on one arc, however
/// far it turns. What a motion is beyond one arc is kept to first order where the wheels roll
/// somewhat farther or less far, and lost where one rolls the other way. Covariances are kept.
/// @param believed,changed  wheel separation before and after [m]
std::vector<Sight> withOtherWheels(const std::vector<Sight>& sights,
                                   const Eigen::Matrix2d& wheels_from_wheels,
                                   double believed_separation_m, double changed_separation_m);

/// The record as it would be with left and right wheel swapped: exact, whatever the motions.
std::vector<Sight> mirrored(const std::vector<Sight>& sights);

/// The record as it would be if each bearing had been taken `earlier_s` before its stamp: poses are
/// interpolated on the arcs between the sights. The first sights have none and are left out.
std::vector<Sight> withEarlierBearings(const std::vector<Sight>& sights, double earlier_s,
                                       double wheel_separation_m);

}  // namespace bearing_calibration
