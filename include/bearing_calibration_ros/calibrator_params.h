#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"
#include "bearing_calibration_ros/wheel_input.h"

namespace bearing_calibration_ros {

/// Parameter group `frames`.
struct FrameNames {
  std::string base;
  std::string sensor;
};

/// Parameter group `output`.
struct OutputConfig {
  std::string folder;          ///< where result.yaml is written
  double save_period_s = 0.0;  ///< wall time between two savings without being asked; 0 is never
  bool publish_tf = false;
  std::string tf_child_frame;  ///< of its own: a frame may have one parent only
  std::string start_frame;     ///< of the markers that stand in the world: the base's child, too
  double max_rate_hz = 0.0;    ///< of the estimate, in wall time
  double prediction_rate_hz = 0.0;  ///< of the predicted bearing, in the encoders' time

  void declare(const FrameNames& frames, core::Parameters& params);
};

/// Everything that the calibration nodelet reads from its private parameters:
/// config/calibration.yaml.
struct CalibrationNodeConfig {
  FrameNames frames;
  WheelInput wheels;
  core::CalibratorConfig calibrator;
  core::UnestimatedMount unestimated_mount;
  bool resume = false;  ///< go on from the result.yaml that is there at the start
  OutputConfig output;
  double max_step_back_s = 0.0;  ///< of ROS time and of the encoders' stamps; more begins anew
  double input_timeout_s = 0.0;  ///< a stream silent for longer is said to be missing
  std::map<std::string, std::string> texts;  ///< every parameter's value in YAML, for the record

  void declare(core::Parameters& params);
};

/// Whether the reader of output/folder is going to write into it.
enum class ResultFolder : std::uint8_t { kUnused, kWritten };

/// @throws std::runtime_error with one line for each parameter that is missing, wrong or unknown.
CalibrationNodeConfig readCalibrationNodeConfig(ParamReader params,
                                                ResultFolder folder = ResultFolder::kUnused);

/// A leading ~/ is the user's home folder, as in a shell.
std::string expandHome(const std::string& folder);

/// Tries to write into the folder that this one stands for (see OwnedFolder), makes it where it is
/// missing, and clears away what a killed writer has left.
/// @returns in words why that cannot be, with the system's reason; empty when it can
std::string whyNotWritable(const std::string& folder);

}  // namespace bearing_calibration_ros
