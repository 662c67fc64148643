#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bearing_calibration/init/closed_form.h"
#include "bearing_calibration/record/observation_path.h"

namespace bearing_calibration::core {

/// The whole record, its halves and its quarters: with a slipping wheel in one of them, another one
/// may still be sound. Stretches of too few observations are left out.
std::vector<Stretch> startWindows(std::size_t observations);

/// Mount and light that most bearings of a window agree on: the closed form on random draws of
/// observations, the best one refitted on what agrees with it (start.md, "Outliers").
/// State at the record's first observation.
/// @param one_of_many  among many hypotheses of the path: fewer draws then
FixedPathFit findConsensus(const std::vector<PosedObservation>& observations, const Stretch& window,
                           std::uint32_t seed, bool one_of_many = false);

/// How near two mounts are for a start to take them for one, on a path of this extent: 10 cm, or
/// less where the path is small.
double sameMountWithin(double extent_m);

/// Fits that findOtherMinima() begins.
inline constexpr int kYawsAround = 8;

/// Other local minima of the cost than those near `found`: fits from yaws all around, best first.
/// @param within_m  see isSameMount()
std::vector<FixedPathFit> findOtherMinima(const std::vector<PosedObservation>& observations,
                                          const Vector5& found, double within_m);

/// Whether two states mean the same mount, as far as a start needs to tell.
bool isSameMount(const Vector5& a, const Vector5& b, double within_m);

}  // namespace bearing_calibration::core
