#include "bearing_calibration_ros/result_saving.h"

#include <ros/common.h>
#include <ros/time.h>

#include <boost/date_time/posix_time/posix_time.hpp>
#include <filesystem>
#include <map>

#include "bearing_calibration/output/result_store.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

std::string wallTimeText() {
  return boost::posix_time::to_iso_extended_string(ros::WallTime::now().toBoost()) + "Z";
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

}  // namespace

std::optional<core::SavedCalibration> savedFrom(const core::CalibrationResult& result,
                                                const CalibrationNodeConfig& config,
                                                const std::string& program,
                                                const std::string& source) {
  if (!result.base_from_sensor || !result.paper_state || !result.cartesian_state) {
    return std::nullopt;
  }
  core::SavedCalibration saved;
  saved.result = result;
  saved.base_frame = config.frames.base;
  saved.sensor_frame = config.frames.sensor;
  saved.lasting = core::lastingPart(*result.estimate);
  saved.unestimated = config.unestimated_mount;
  saved.rejections = rejectionsText(result, 0);
  saved.provenance = {program,    wallTimeText(), source, config.calibrator.drive,
                      versions(), config.texts};
  return saved;
}

EarlierResult readEarlierResult(const CalibrationNodeConfig& config) {
  const std::string path = core::resultPathIn(config.output.folder);
  if (!std::filesystem::exists(path)) return {std::nullopt, "nothing to resume: no " + path};
  const core::ResultFileContent content = core::readResultFile(path);
  if (!content.calibration) return {std::nullopt, "not resumed: " + content.error};
  const core::SavedCalibration& saved = *content.calibration;
  std::string why = core::whyOfAnotherRobot(saved, config.frames.base, config.frames.sensor,
                                            config.calibrator.drive);
  if (why.empty() && !core::mayBeTrusted(saved.result.state)) {
    why = std::string("it was ") + core::nameOf(saved.result.state) + " when it was written";
  }
  if (!why.empty()) return {std::nullopt, "not resumed: " + path + ": " + why};
  return {saved.lasting, "resumed from " + path + ", written " + saved.provenance.written_at};
}

}  // namespace bearing_calibration_ros
