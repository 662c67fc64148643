#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace bearing_calibration::core {

/// The value that so large a share in [0, 1) of all is below. There is at least one.
inline double quantileOf(std::vector<double> values, double share) {
  const auto place =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}
inline double medianOf(std::vector<double> values) { return quantileOf(std::move(values), 0.5); }

/// Standard deviation of residuals that are normal but for a few.
inline double robustStddev(std::vector<double> residuals) {
  constexpr double kMedianOfNormal = 0.67449;  // of its absolute value
  for (double& residual : residuals) residual = std::abs(residual);
  return medianOf(std::move(residuals)) / kMedianOfNormal;
}

}  // namespace bearing_calibration::core
