#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core {

/// An observation with the pose at which the odometry says it was made.
struct PosedObservation {
  Pose2 first_from_base;  ///< base frame of the record's first observation from that of this one
  double azimuth_rad = 0.0;
  double azimuth_variance_rad2 = 0.0;
  double heading_variance_rad2 = 0.0;  ///< of the odometry, grown since the first observation
  double position_variance_m2 = 0.0;   ///< of the odometry along one axis, grown without headings
};

/// A stretch of a record: observations [begin, end).
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;

  std::size_t size() const { return end - begin; }
  std::size_t middle() const { return (begin + end) / 2; }
};

/// The record with the odometry taken at its word.
std::vector<PosedObservation> poseObservations(const std::vector<Observation>& observations);

/// So many observations of a record, as ObservationRecord keeps them.
std::vector<Observation> thinned(const std::vector<Observation>& observations,
                                 std::size_t max_observations);

/// The record as it would be if the wheels had rolled `wheels_from_wheels` times what they
/// said: a matrix that maps (left, right) to (left, right). Exact for a motion on one arc, however
/// far it turns. What a motion is beyond one arc is kept to first order where the wheels roll
/// somewhat farther or less far, and lost where one rolls the other way. Covariances are kept.
/// @param nominal_separation_m,changed_separation_m  before and after [m]
std::vector<Observation> withOtherWheels(const std::vector<Observation>& observations,
                                         const Eigen::Matrix2d& wheels_from_wheels,
                                         double nominal_separation_m, double changed_separation_m);

/// The record as it would be with left and right wheel swapped: exact, whatever the motions.
std::vector<Observation> mirrored(const std::vector<Observation>& observations);

/// The record as it would be if each bearing had been taken `earlier_s` before its stamp: poses are
/// interpolated on the arcs between the observations. The first observations have none and are left
/// out.
std::vector<Observation> withEarlierBearings(const std::vector<Observation>& observations,
                                             double earlier_s, double wheel_separation_m);

}  // namespace bearing_calibration::core
