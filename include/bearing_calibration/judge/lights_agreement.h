#pragma once

#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {

/// Which of several lights say the same mount. One that moves, or a reflection, may well say a
/// mount, and be sure of it; but not that of the others.
struct LightsAgreement {
  std::vector<std::size_t> agreeing;  ///< indices of those that all agree with each other
  std::vector<std::size_t> contradicting;
};

/// Sorts out those that clearly contradict the others, before there is a joint estimate.
/// @param mounts  one for each light, each from that light's bearings alone. How the wheels' noise,
///   which they share, makes them hang together is not known here: the worst is allowed for.
LightsAgreement compareLights(const std::vector<MountEstimate>& mounts);

/// How far a light's own mount is from the joint one that it is a part of: chi-square with 3
/// degrees of freedom when all of them see the same mount. The covariance of the difference is that
/// of its own less the joint one, since the joint one is the best that can be made of both (Hausman
/// 1978); it counts the noise that they share.
double contradiction(const MountEstimate& own, const MountEstimate& joint);

/// The least of several spreads, each what a covariance lacks by one opinion: a difference of
/// covariances, which may be negative along some directions. Those count as none; and all are
/// measured by `covariance`, so that metres and radians can be compared.
Eigen::Matrix3d leastSpread(const std::vector<Eigen::Matrix3d>& spreads,
                            const Eigen::Matrix3d& covariance);

/// What contradictions of `lights` sound lights stay below, but for one case in 1/`probability`.
double largestContradiction(std::size_t lights, double probability);

}  // namespace bearing_calibration::core
