#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {

/// One of several estimates of the same mount.
struct NamedMount {
  std::string name;
  MountEstimate mount;
};

/// Whether several estimates agree.
struct MountComparison {
  MountEstimate together;  ///< weighted mean, by the inverse covariances
  double chi_square = 0.0;
  int degrees_of_freedom = 0;  ///< three for each estimate but one
  double p_value = 1.0;        ///< chance of so large a chi_square when all are honest
  std::vector<double> shares;  ///< of chi_square, by estimate

  bool agrees() const;
};

/// Holds independent estimates of one mount against their weighted mean: chi-square with
/// 3 (n - 1) degrees of freedom when they all are of the same mount and honest.
/// @throws std::invalid_argument for less than two
MountComparison compareMounts(const std::vector<NamedMount>& mounts);

/// Side by side, for people.
std::string format(const std::vector<NamedMount>& mounts, const MountComparison& comparison);

/// The same as YAML, for the report.
std::string toYaml(const std::vector<NamedMount>& mounts, const MountComparison& comparison);

}  // namespace bearing_calibration::core
