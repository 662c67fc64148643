#pragma once

#include <optional>
#include <string>

#include "bearing_calibration/output/result.h"
#include "bearing_calibration/output/result_file.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// A result as it is saved; none before there is an estimate.
/// @param program,source  what calls, and where its measurements come from: provenance
std::optional<core::SavedCalibration> savedFrom(const core::CalibrationResult& result,
                                                const CalibrationNodeConfig& config,
                                                const std::string& program,
                                                const std::string& source);

/// What is in the configured folder's result.yaml to go on from.
struct EarlierResult {
  std::optional<core::StateEstimate> lasting;
  std::string message;  ///< what was taken up, or why nothing was
};

/// Refuses a file that is missing, corrupt or foreign, was measured with other wheels or between
/// other frames, or was not trusted when it was written.
EarlierResult readEarlierResult(const CalibrationNodeConfig& config);

}  // namespace bearing_calibration_ros
