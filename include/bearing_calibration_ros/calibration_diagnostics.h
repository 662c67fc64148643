#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <string>

#include "bearing_calibration/output/result.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Puts a calibration's state and counts into one diagnostic status: an error when it is
/// inconsistent; a warning when the motion is degenerate, an input is silent (`silence` says which)
/// or inputs were refused or changed since the last status; fine otherwise.
void fillDiagnostics(const core::CalibrationResult& result,
                     std::uint32_t joint_states_without_wheels, const std::string& silence,
                     bool remarks_since_last, diagnostic_updater::DiagnosticStatusWrapper* status);

}  // namespace bearing_calibration_ros
