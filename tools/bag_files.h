#pragma once

#include <optional>
#include <string>

#include "tools/bag_calibration.h"

namespace bearing_calibration {

/// Writes what the report of one calibration is made of into a folder: estimates.csv (the running
/// estimate), looks.csv (every image) and details.yaml, beside the result's own files where there
/// is an estimate.
/// @returns what went wrong; nothing when all is written.
std::optional<std::string> writeBagFiles(const std::string& folder, const BagJob& job,
                                         const BagSetup& setup, const BagOutcome& outcome);

}  // namespace bearing_calibration
