#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

#include "bearing_calibration/filter/observation.h"

namespace bearing_calibration::core {

/// Some observations that follow each other.
struct Stretch {
  std::size_t begin = 0;
  std::size_t end = 0;

  std::size_t size() const { return end - begin; }
};

/// All longest stretches in each of which `belongs(i)` holds from the second observation on, and
/// nothing is missing for long: a bag may hold two recordings.
template <class Belongs>
std::vector<Stretch> stretchesOf(const std::vector<Observation>& observations,
                                 const Belongs& belongs) {
  constexpr Duration kLongestGap = std::chrono::seconds(5);
  std::vector<Stretch> stretches;
  Stretch now;
  for (std::size_t i = 1; i <= observations.size(); ++i) {
    now.end = i;
    const bool goes_on =
        i < observations.size() && observations[i].stamp - observations[i - 1].stamp <= kLongestGap;
    if (goes_on && belongs(i)) continue;
    if (now.size() > 1) stretches.push_back(now);
    now.begin = i;
  }
  return stretches;
}

}  // namespace bearing_calibration::core
