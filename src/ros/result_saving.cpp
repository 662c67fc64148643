#include "bearing_calibration_ros/result_saving.h"

#include <ros/common.h>
#include <ros/time.h>

#include <algorithm>
#include <boost/date_time/posix_time/posix_time.hpp>
#include <filesystem>
#include <map>

#include "bearing_calibration/calibration/result_export.h"
#include "bearing_calibration/calibration/result_file.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration;

std::string wallTimeText() {
  return boost::posix_time::to_iso_extended_string(ros::WallTime::now().toBoost()) + "Z";
}

std::string pathOf(const CalibrationNodeConfig& config) {
  return std::filesystem::absolute(config.output.folder) / "result.yaml";
}

/// "1.2.3" as a YAML string.
template <typename... Numbers>
std::string versionText(int first, Numbers... others) {
  std::string text = '"' + std::to_string(first);
  ((text += "." + std::to_string(others)), ...);
  return text + '"';
}

std::map<std::string, std::string> versions() {
  return {
      {"bearing_calibration", '"' + std::string(BEARING_CALIBRATION_VERSION) + '"'},
      {"roscpp", versionText(ROS_VERSION_MAJOR, ROS_VERSION_MINOR, ROS_VERSION_PATCH)},
      {"eigen", versionText(EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
  };
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
                         const std::string& folder, const std::string& program,
                         const std::string& source) {
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
  saved.robot_errors = core::reportBlocks(
      result.error_priors, result.robot_errors,
      std::max(saved.unestimated.roll_stddev_rad, saved.unestimated.pitch_stddev_rad));
  saved.lights = result.lights;
  for (const core::BlockReport& report :
       core::reportNoise(result.noise_priors, result.noise, result.correlation_time)) {
    saved.robot_errors.push_back(report);
  }
  saved.nis_mean = result.nis_mean;
  saved.distance_travelled_m = result.distance_travelled_m;
  saved.rotation_travelled_rad = result.rotation_travelled_rad;
  saved.bearings_used = result.bearings_used;
  saved.bearings_gated = result.bearings_gated;
  saved.ticks_used = result.ticks_used;
  saved.rejections = rejectionsText(result, 0);
  saved.provenance = {program,    wallTimeText(), source, config.calibrator.drive,
                      versions(), config.texts};

  const std::string path = std::filesystem::absolute(folder);
  if (const auto error = core::writeResultFolder(path, saved)) return {false, *error};
  return {true, "written to " + path + "/result.yaml"};
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
