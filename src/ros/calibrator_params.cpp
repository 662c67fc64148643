#include "bearing_calibration_ros/calibrator_params.h"

#include <cstdlib>
#include <exception>

#include "bearing_calibration/common/owned_folder.h"
#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration_ros {
namespace {

FrameNames readFrames(ParamReader& params) {
  return {params.text("frames/base"), params.text("frames/sensor")};
}

core::BearingInputConfig readBearings(ParamReader& params) {
  core::BearingInputConfig bearings;
  bearings.latency_s = params.number("bearings/latency");
  bearings.extra_stddev_rad = params.number("bearings/extra_stddev");
  bearings.min_stddev_rad = params.number("bearings/min_stddev");
  bearings.max_stddev_rad = params.number("bearings/max_stddev");
  bearings.max_future_s = params.number("bearings/max_future");
  bearings.reorder_window_s = params.number("bearings/reorder_window");
  bearings.max_waiting = params.integer("bearings/max_waiting");
  bearings.min_probability = params.number("bearings/min_probability");
  return bearings;
}

core::InitialisationConfig readInitialisation(ParamReader& params) {
  constexpr core::InitialisationConfig::Kind kKinds[] = {core::InitialisationConfig::Kind::kNothing,
                                                         core::InitialisationConfig::Kind::kGuess};
  core::InitialisationConfig initialisation;
  initialisation.kind = kKinds[params.choice("initialisation/from", {"nothing", "guess"})];
  initialisation.light_distance_m = params.number("initialisation/light_distance");
  initialisation.light_distance_stddev_m = params.number("initialisation/light_distance_stddev");
  initialisation.x_m = params.number("initialisation/x");
  initialisation.y_m = params.number("initialisation/y");
  initialisation.position_stddev_m = params.number("initialisation/position_stddev");
  initialisation.yaw_rad = params.number("initialisation/yaw");
  initialisation.yaw_stddev_rad = params.number("initialisation/yaw_stddev");
  return initialisation;
}

core::FilterConfig readFilter(ParamReader& params) {
  using Parametrisation = core::FilterConfig::Parametrisation;
  constexpr Parametrisation kParametrisations[] = {Parametrisation::kCartesian,
                                                   Parametrisation::kPaper};
  core::FilterConfig filter;
  filter.parametrisation =
      kParametrisations[params.choice("filter/parametrisation", {"cartesian", "paper"})];
  filter.gate_probability = params.number("filter/gate_probability");
  filter.recovery_after = params.integer("filter/recovery_after");
  filter.recovery_bearing_stddev_rad = params.number("filter/recovery_bearing_stddev");
  filter.recovery_distance_stddev_m = params.number("filter/recovery_distance_stddev");
  return filter;
}

core::ErrorPriors readErrors(ParamReader& params) {
  core::ErrorPriors priors;
  for (const core::ErrorBlockInfo& block : core::errorBlocks()) {
    if (block.said_by_sensor) continue;
    priors.setBlock(block.name, params.number("errors/" + block.name + "_stddev"));
  }
  priors.setLightHeight(params.number("errors/light_height"),
                        params.number("errors/light_height_stddev"));
  return priors;
}

core::NoisePriors readNoise(ParamReader& params) {
  return {params.number("errors/bearing_noise_stddev"), params.number("errors/wheel_noise_stddev")};
}

core::CalibratorConfig readCalibrator(const WheelParams& wheels, ParamReader& params) {
  core::CalibratorConfig config;
  config.drive = wheels.drive;
  config.wheel_noise = wheels.noise;
  config.max_wheels_apart_s = wheels.max_apart_s;
  config.tick_history_s = wheels.history_s;
  config.bearings = readBearings(params);
  config.initialisation = readInitialisation(params);
  config.filter = readFilter(params);
  config.converged.position_stddev_m = params.number("converged/position_stddev");
  config.converged.yaw_stddev_rad = params.number("converged/yaw_stddev");
  config.restart_on_mount_change = params.boolean("session/restart_on_mount_change");
  config.max_lights = params.integer("session/max_lights");
  config.initializer.batch.errors = readErrors(params);
  config.initializer.noise = readNoise(params);
  return config;
}

core::UnestimatedMount readUnestimatedMount(ParamReader& params) {
  core::UnestimatedMount mount;
  mount.z_m = params.number("mount/z");
  mount.z_stddev_m = params.number("mount/z_stddev");
  mount.roll_rad = params.number("mount/roll");
  mount.roll_stddev_rad = params.number("mount/roll_stddev");
  mount.pitch_rad = params.number("mount/pitch");
  mount.pitch_stddev_rad = params.number("mount/pitch_stddev");
  return mount;
}

/// A leading ~/ is the user's home folder, as in a shell.
std::string expandHome(const std::string& folder) {
  const char* home = std::getenv("HOME");
  return folder.compare(0, 2, "~/") == 0 && home != nullptr ? home + folder.substr(1) : folder;
}

OutputConfig readOutput(ParamReader& params) {
  OutputConfig output;
  output.folder = expandHome(params.text("output/folder"));
  output.save_period_s = params.number("output/save_period");
  output.publish_tf = params.boolean("output/publish_tf");
  output.tf_child_frame = params.text("output/tf_child_frame");
  output.start_frame = params.text("output/start_frame");
  output.max_rate_hz = params.number("output/max_rate");
  output.prediction_rate_hz = params.number("output/prediction_rate");
  return output;
}

void requireFrameName(const std::string& name, const std::string& value,
                      core::Requirements* require) {
  require->that(!value.empty() && value.front() != '/' && value.find(' ') == std::string::npos,
                name +
                    " must be a frame's name without slash in front and without spaces, but is '" +
                    value + "'");
}

}  // namespace

std::vector<std::string> FrameNames::validate() const {
  core::Requirements require;
  requireFrameName("frames/base", base, &require);
  requireFrameName("frames/sensor", sensor, &require);
  require.that(sensor != base,
               "frames/sensor must not be frames/base, but both are '" + base + "'");
  return require.errors();
}

std::vector<std::string> OutputConfig::validate(const FrameNames& frames) const {
  core::Requirements require;
  require.that(!folder.empty(), "output/folder must not be empty");
  requireFrameName("output/tf_child_frame", tf_child_frame, &require);
  require.that(tf_child_frame != frames.base,
               "output/tf_child_frame must not be frames/base, but both are '" + frames.base + "'");
  requireFrameName("output/start_frame", start_frame, &require);
  require.that(
      start_frame != frames.base && start_frame != frames.sensor && start_frame != tf_child_frame,
      "output/start_frame must be a frame of its own, but is '" + start_frame + "'");
  using namespace core::plausible;
  constexpr double kShortestSavePeriod_s = 1.0;  // the writes of a card are counted
  require.that(save_period_s == 0.0 ||
                   (save_period_s >= kShortestSavePeriod_s && save_period_s <= kLongest_s),
               "output/save_period must be 0 (never) or at least 1 s and at most a day, but is " +
                   std::to_string(save_period_s));
  require.between("output/max_rate", max_rate_hz, kRarest_hz, kMostFrequent_hz);
  require.between("output/prediction_rate", prediction_rate_hz, kRarest_hz, kMostFrequent_hz);
  return require.errors();
}

std::optional<std::string> whyNotWritable(const std::string& folder) {
  try {
    core::OwnedFolder(folder).tryToWrite();
    return std::nullopt;
  } catch (const std::exception& error) {
    return error.what();
  }
}

CalibrationNodeConfig readCalibrationNodeConfig(ParamReader params, ResultFolder folder) {
  CalibrationNodeConfig config;
  config.frames = readFrames(params);
  const WheelParams wheels = readWheels(params);
  config.wheel_source = wheels.source;
  config.joints = wheels.joints;
  config.calibrator = readCalibrator(wheels, params);
  config.unestimated_mount = readUnestimatedMount(params);
  config.resume = params.boolean("session/resume");
  config.output = readOutput(params);
  config.max_step_back_s = params.number("clock/max_step_back");
  config.input_timeout_s = params.number("diagnostics/input_timeout");
  config.texts = params.texts();

  core::Requirements require;
  require.add(config.frames.validate());
  require.add(config.calibrator.validate());
  require.add(config.unestimated_mount.validate());
  require.add(config.output.validate(config.frames));
  constexpr double kLeastStepBack_s = 0.1;  // threads read a running clock in any order
  constexpr double kMostStepBack_s = 60.0;  // so long the robot may be without readings
  require.between("clock/max_step_back", config.max_step_back_s, kLeastStepBack_s, kMostStepBack_s);
  require.between("diagnostics/input_timeout", config.input_timeout_s, core::plausible::kBriefest_s,
                  core::plausible::kLongest_s);
  require.add(wheels.validate());
  if (folder == ResultFolder::kWritten && !config.output.folder.empty()) {
    const auto why = whyNotWritable(config.output.folder);
    require.that(!why, "output/folder " + why.value_or(""));
  }
  params.addErrors(require.errors());
  params.throwIfAnyError();
  return config;
}

}  // namespace bearing_calibration_ros
