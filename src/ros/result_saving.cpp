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

  const std::string path = std::filesystem::absolute(config.output.folder) / "result.yaml";
  if (const auto error = core::writeResultFile(path, saved)) return {false, *error};
  return {true, "written to " + path};
}

}  // namespace bearing_calibration_ros
