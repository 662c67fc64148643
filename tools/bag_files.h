#pragma once

#include <string>

#include "bearing_calibration/calibration/result_store.h"
#include "tools/bag_calibration.h"

namespace bearing_calibration {

/// Saves the result of one calibration, where there is an estimate, with what the report is made
/// of: details.yaml, estimates.csv (the running estimate), looks.csv (every image), plans.csv.
StoredResult storeBagFiles(const std::string& folder, const BagJob& job, const BagSetup& setup,
                           const BagOutcome& outcome);

}  // namespace bearing_calibration
