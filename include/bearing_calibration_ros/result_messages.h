#pragma once

#include <bearing_calibration/CalibrationEstimate.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/output/result.h"
#include "bearing_calibration_ros/namespaces.h"

/// What a calibration knows, as messages. Joint states without the wheels never reach the core, so
/// they are counted beside its result.
namespace bearing_calibration_ros {

/// "bearings stamp in the future: 3; ..." over both streams, empty when nothing was refused or
/// changed.
std::string rejectionsText(const core::CalibrationResult& result,
                           std::uint32_t joint_states_without_wheels);

/// NaN where there is no estimate yet.
msg::CalibrationEstimate messageFromResult(const core::CalibrationResult& result,
                                           std::uint32_t joint_states_without_wheels,
                                           const std::string& base_frame);
/// Light and mount of such a message, with the errors of clock and wheels, and its other lights;
/// none where it has no estimate yet.
std::optional<core::StateEstimate> robotFromMessage(const msg::CalibrationEstimate& message);

/// State and counts as one diagnostic status: an error when the calibration is inconsistent; a
/// warning when the motion is degenerate, an input is silent (`silence` says which) or inputs were
/// refused or changed since the last status; fine otherwise.
void fillDiagnostics(const core::CalibrationResult& result,
                     std::uint32_t joint_states_without_wheels, const std::string& silence,
                     bool remarks_since_last, diagnostic_updater::DiagnosticStatusWrapper* status);

}  // namespace bearing_calibration_ros
