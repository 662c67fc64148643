#pragma once

#include <string>

#include "bearing_calibration/output/result_store.h"
#include "tools/owner/bag_calibration.h"

namespace bearing_calibration::core {

/// Saves the result of one calibration, where there is an estimate, with what the report is made
/// of: details.yaml, estimates.csv (the running estimate), images.csv (every image), plans.csv.
StoredResult storeBagFiles(const std::string& folder, const BagJob& job, const BagSetup& setup,
                           const BagOutcome& outcome);

}  // namespace bearing_calibration::core
