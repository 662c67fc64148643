#include "bearing_calibration_ros/result_saving.h"

#include <ros/time.h>

#include <boost/date_time/posix_time/posix_time.hpp>
#include <filesystem>

#include "bearing_calibration/calibration/result_file.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration;

std::string wallTimeText() {
  return boost::posix_time::to_iso_extended_string(ros::WallTime::now().toBoost()) + "Z";
}

std::string pathOf(const CalibrationNodeConfig& config) {
  return std::filesystem::absolute(config.output.folder) / "result.yaml";
}

/// Why a saved calibration is not one of this robot; empty when it is.
std::string whyForeign(const core::SavedCalibration& saved, const CalibrationNodeConfig& config) {
  const core::DriveGeometry& then = saved.provenance.drive;
  const core::DriveGeometry& now = config.calibrator.drive;
  if (saved.base_frame != config.frames.base || saved.sensor_frame != config.frames.sensor) {
    return "it is of " + saved.base_frame + " and " + saved.sensor_frame;
  }
  if (then.wheel_separation_m != now.wheel_separation_m ||
      then.left_wheel_radius_m != now.left_wheel_radius_m ||
      then.right_wheel_radius_m != now.right_wheel_radius_m) {
    return "it was measured with other wheels/separation, left_radius or right_radius";
  }
  if (saved.state != core::CalibrationState::kConverged &&
      saved.state != core::CalibrationState::kConverging) {
    return std::string("it was ") + core::nameOf(saved.state) + " when it was written";
  }
  return {};
}

}  // namespace

SavingOutcome saveResult(const core::CalibrationResult& result, const CalibrationNodeConfig& config,
                         const std::string& program) {
  if (!result.base_from_sensor || !result.paper_state || !result.cartesian_state) {
    return {false, std::string("there is no estimate to save yet: ") + core::nameOf(result.state)};
  }
  core::SavedCalibration saved;
  saved.state = result.state;
  saved.advice = result.advice;
  saved.stamp = result.stamp;
  saved.base_frame = config.frames.base;
  saved.sensor_frame = config.frames.sensor;
  saved.base_from_sensor = *result.base_from_sensor;
  saved.unestimated = config.unestimated_mount;
  saved.paper_state = *result.paper_state;
  saved.cartesian_state = *result.cartesian_state;
  saved.nis_mean = result.nis_mean;
  saved.distance_travelled_m = result.distance_travelled_m;
  saved.rotation_travelled_rad = result.rotation_travelled_rad;
  saved.bearings_used = result.bearings_used;
  saved.bearings_gated = result.bearings_gated;
  saved.provenance = {program, wallTimeText(), config.calibrator.drive};

  const std::string path = pathOf(config);
  if (const auto error = core::writeResultFile(path, saved)) return {false, *error};
  return {true, "written to " + path};
}

EarlierResult readEarlierResult(const CalibrationNodeConfig& config) {
  const std::string path = pathOf(config);
  if (!std::filesystem::exists(path)) return {std::nullopt, "nothing to take up: no " + path};
  const core::ResultFileContent content = core::readResultFile(path);
  if (!content.calibration) return {std::nullopt, "not taken up: " + content.error};
  const std::string why = whyForeign(*content.calibration, config);
  if (!why.empty()) return {std::nullopt, "not taken up: " + path + ": " + why};
  return {content.calibration->base_from_sensor,
          "goes on from " + path + ", written " + content.calibration->provenance.written_at};
}

}  // namespace bearing_calibration_ros
