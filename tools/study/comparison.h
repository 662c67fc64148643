#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/study/comparison_estimators.h"

namespace bearing_calibration::core {

/// A setting in which the estimators are compared.
struct ComparisonSetting {
  std::string name;
  SimulatedCase (*make)(std::uint64_t seed);
};

/// The paper's world and the short drive, noise as stated and not, and a robot with a late camera
/// and unequal wheels.
const std::vector<ComparisonSetting>& comparisonSettings();

/// What every estimator says in every run of a setting: [estimator][run]. The runs are those of the
/// seeds 1 to `runs`.
std::vector<std::vector<Snapshot>> compare(const ComparisonSetting& setting, int runs, int threads);

/// What each estimator is given, as a table in Markdown.
std::string formatGiven();
/// A setting's table in Markdown, under its name.
std::string formatComparison(const ComparisonSetting& setting,
                             const std::vector<std::vector<Snapshot>>& snapshots);

}  // namespace bearing_calibration::core
