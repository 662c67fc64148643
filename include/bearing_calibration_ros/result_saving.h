#pragma once

#include <string>

#include "bearing_calibration/calibration/result.h"
#include "bearing_calibration_ros/calibrator_params.h"

namespace bearing_calibration_ros {

/// What ~save answers.
struct SavingOutcome {
  bool success = false;
  std::string message;  ///< names the file, or says why there is none
};

/// Writes result.yaml into the configured folder, with wall time and `program` as its provenance.
SavingOutcome saveResult(const bearing_calibration::CalibrationResult& result,
                         const CalibrationNodeConfig& config, const std::string& program);

}  // namespace bearing_calibration_ros
