#include "bearing_calibration_ros/calibrator_params.h"

#include <cstdlib>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration_ros/sensor_places.h"
#include "bearing_calibration_ros/thrown.h"

namespace bearing_calibration_ros {

void OutputConfig::declare(const FrameNames& frames, core::Parameters& params) {
  using namespace core::plausible;
  constexpr double kShortestSavePeriod_s = 1.0;  // the writes of a card are counted
  params.read("output/folder", folder);
  folder = expandHome(folder);
  params.notEmpty("output/folder", folder);
  params.read("output/publish_tf", publish_tf);
  declareFrame("output/tf_child_frame", tf_child_frame, params);
  params.that(tf_child_frame != frames.base,
              "output/tf_child_frame must not be frames/base, but both are '" + frames.base + "'");
  declareFrame("output/start_frame", start_frame, params);
  params.that(
      start_frame != frames.base && start_frame != frames.sensor && start_frame != tf_child_frame,
      "output/start_frame must be a frame of its own, but is '" + start_frame + "'");
  params.read("output/save_period", save_period_s);
  params.that(save_period_s == 0.0 ||
                  (save_period_s >= kShortestSavePeriod_s && save_period_s <= kLongest_s),
              "output/save_period must be 0 (never) or at least 1 s and at most a day, but is " +
                  std::to_string(save_period_s));
  params.number("output/max_rate", max_rate_hz, kRarest_hz, kMostFrequent_hz);
  params.number("output/prediction_rate", prediction_rate_hz, kRarest_hz, kMostFrequent_hz);
}

void CalibrationNodeConfig::declare(core::Parameters& params) {
  constexpr double kLeastStepBack_s = 0.1;  // threads read a running clock in any order
  constexpr double kMostStepBack_s = 60.0;  // so long the robot may be without readings
  declareFrame("frames/base", frames.base, params);
  declareFrame("frames/sensor", frames.sensor, params);
  params.that(frames.sensor != frames.base,
              "frames/sensor must not be frames/base, but both are '" + frames.base + "'");
  wheels.declare(params);
  calibrator.declare(params);
  unestimated_mount.declare(params);
  params.read("session/resume", resume);
  output.declare(frames, params);
  params.number("clock/max_step_back", max_step_back_s, kLeastStepBack_s, kMostStepBack_s);
  params.number("diagnostics/input_timeout", input_timeout_s, core::plausible::kBriefest_s,
                core::plausible::kLongest_s);
}

std::string expandHome(const std::string& folder) {
  const char* home = std::getenv("HOME");
  return folder.compare(0, 2, "~/") == 0 && home != nullptr ? home + folder.substr(1) : folder;
}

std::string whyNotWritable(const std::string& folder) {
  return thrownBy([&folder] { core::OwnedFolder(folder).tryToWrite(); });
}

CalibrationNodeConfig readCalibrationNodeConfig(ParamReader params, ResultFolder folder) {
  CalibrationNodeConfig config;
  config.declare(params);
  config.texts = params.texts();
  if (folder == ResultFolder::kWritten && !config.output.folder.empty()) {
    const std::string why = whyNotWritable(config.output.folder);
    params.that(why.empty(), "output/folder " + why);
  }
  params.throwIfAnyError();
  return config;
}

}  // namespace bearing_calibration_ros
