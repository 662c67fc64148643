#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/record/observation_path.h"

namespace bearing_calibration::core {

/// A search runs on so many observations at most, whatever the record's length.
inline constexpr std::size_t kObservationsOfSearch = 150;

/// The path of a robot with these errors.
std::vector<PosedObservation> poseWithout(const std::vector<Observation>& observations,
                                          const ErrorVector& errors);

/// The batch, begun at an observation by a state on that path.
BatchEstimate refine(const std::vector<Observation>& observations, const Vector5& state_at_first,
                     std::size_t observation, const ErrorVector& errors,
                     const InitializerConfig& config);

/// A mount beside that of a fit.
struct OtherAnswer {
  double gap = 0.0;                  ///< log-likelihood by which the fit is ahead
  Eigen::Vector3d mount;             ///< x [m], y [m], yaw [rad]
  std::optional<BatchEstimate> fit;  ///< none where a sound record rules it out at once
};

/// The other minima of a record, found from yaws all around, best first.
/// @param found  of all `observations`
std::vector<OtherAnswer> findOtherAnswers(const std::vector<Observation>& observations,
                                          const BatchEstimate& found,
                                          const InitializerConfig& config);

}  // namespace bearing_calibration::core
