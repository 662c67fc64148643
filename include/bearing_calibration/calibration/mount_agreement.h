#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/calibration/batch_estimator.h"
#include "bearing_calibration/filter/paper_state.h"

namespace bearing_calibration {

/// Squared Mahalanobis distance of two independent estimates of one mount: chi-square with 3
/// degrees of freedom when both are honest.
double disagreement(const MountEstimate& a, const MountEstimate& b);

/// An estimate together with what is known of the mount from elsewhere, independently.
CartesianEstimate withKnownMount(const CartesianEstimate& estimate, const MountEstimate& known);

/// What a part of a record says for itself, begun from what the whole says.
/// @param at_last  the whole's estimate at the record's last sight
/// @param begin,end  sights [begin, end) of the record
/// @returns none when the part did not settle
std::optional<MountEstimate> estimatePart(const std::vector<Sight>& sights, const Vector5& at_last,
                                          std::size_t begin, std::size_t end,
                                          const BatchConfig& config);

/// Disagreement of the two halves of a record, each estimated for itself; none when one of them
/// cannot be. Halves by motion, not by time.
std::optional<double> halvesDisagreement(const std::vector<Sight>& sights, const Vector5& at_last,
                                         const BatchConfig& config);

}  // namespace bearing_calibration
