#pragma once

namespace bearing_calibration::core {

/// Value that a chi-square variable with `degrees_of_freedom` stays below with `probability`.
/// @throws std::domain_error unless degrees_of_freedom > 0 and 0 <= probability < 1.
double chiSquareQuantile(double probability, double degrees_of_freedom);

/// Value that it exceeds with `probability`, which may be so small that 1 less it would be 1.
/// @throws std::domain_error unless degrees_of_freedom > 0 and 0 < probability <= 1.
double chiSquareExceededBy(double probability, double degrees_of_freedom);

/// Probability that a chi-square variable with `degrees_of_freedom` stays below `value` >= 0.
double chiSquareProbability(double value, double degrees_of_freedom);

}  // namespace bearing_calibration::core
