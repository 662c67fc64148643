#include "bearing_calibration_ros/calibration_diagnostics.h"

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {

using diagnostic_msgs::DiagnosticStatus;

void fillDiagnostics(const core::CalibrationResult& result,
                     std::uint32_t joint_states_without_wheels, const std::string& silence,
                     bool remarks_since_last, diagnostic_updater::DiagnosticStatusWrapper* status) {
  const std::string rejections = rejectionsText(result, joint_states_without_wheels);
  status->summary(DiagnosticStatus::OK,
                  std::string(core::nameOf(result.state)) + ": " + result.advice);
  if (result.state == core::CalibrationState::kInconsistent) {
    status->mergeSummary(DiagnosticStatus::ERROR, "do not use the result");
  }
  if (result.state == core::CalibrationState::kDegenerateMotion) {
    status->mergeSummary(DiagnosticStatus::WARN, "the motion does not determine the mount");
  }
  if (!silence.empty()) status->mergeSummary(DiagnosticStatus::WARN, silence);
  if (remarks_since_last) {
    status->mergeSummary(DiagnosticStatus::WARN, "inputs are refused or changed");
  }

  if (result.base_from_sensor) {
    const Eigen::Vector3d& mean = result.base_from_sensor->mean;
    const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
    status->addf("x [m]", "%.4f +- %.4f", mean.x(), stddev.x());
    status->addf("y [m]", "%.4f +- %.4f", mean.y(), stddev.y());
    status->addf("yaw [deg]", "%.3f +- %.3f", core::degreesFromRadians(mean.z()),
                 core::degreesFromRadians(stddev.z()));
  }
  status->addf("NIS, running mean (1 is consistent)", "%.3f", result.nis_mean);
  status->addf("distance travelled [m]", "%.2f", result.distance_travelled_m);
  status->addf("rotation travelled [deg]", "%.0f",
               core::degreesFromRadians(result.rotation_travelled_rad));
  status->add("bearings used", result.bearings_used);
  status->add("bearings gated", result.bearings_gated);
  status->add("bearings waiting for ticks", result.bearings_waiting);
  status->add("wheel readings used", result.ticks_used);
  status->add("inputs refused", rejections.empty() ? "none" : rejections);
}

}  // namespace bearing_calibration_ros
