#include "bearing_calibration_ros/simulation_params.h"

#include <ros/time.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration_ros/scene_params.h"

namespace bearing_calibration_ros {
namespace {

constexpr char kCommanded[] = "cmd_vel";  // a trajectory of its own beside the named ones

DrivingConfig readDriving(ParamReader& params, std::uint64_t seed) {
  std::vector<std::string> kinds = core::trajectoryNames();
  kinds.emplace_back(kCommanded);
  const std::size_t kind = params.choice("trajectory/kind", kinds);
  DrivingConfig driving;
  driving.follows_commands = kinds[kind] == kCommanded;
  core::TrajectoryConfig& trajectory = driving.trajectory;
  if (!driving.follows_commands) {
    trajectory.kind = static_cast<core::TrajectoryConfig::Kind>(kind);
  }
  trajectory.wheel_speed_mps = params.number("trajectory/wheel_speed");
  trajectory.segment_length_m = params.number("trajectory/segment_length");
  trajectory.dance_turn_rad = params.number("trajectory/dance_turn");
  trajectory.circle_radius_m = params.number("trajectory/circle_radius");
  trajectory.sinusoid_amplitude_rad = params.number("trajectory/sinusoid_amplitude");
  trajectory.sinusoid_period_s = params.number("trajectory/sinusoid_period");
  trajectory.random_variance_m = params.number("trajectory/random_variance");
  trajectory.seed = seed;
  driving.duration_s = params.number("trajectory/duration");
  driving.stops_at_end = params.choice("trajectory/at_end", {"hold", "stop"}) == 1;
  driving.command_timeout_s = params.number("trajectory/command_timeout");
  return driving;
}

core::EncoderConfig readEncoders(ParamReader& params) {
  core::EncoderConfig encoders;
  encoders.drive.wheel_separation_m = params.number("wheels/separation");
  encoders.drive.left_wheel_radius_m = params.number("wheels/left_radius");
  encoders.drive.right_wheel_radius_m = params.number("wheels/right_radius");
  encoders.drive.ticks_per_revolution = params.number("wheels/ticks_per_revolution");
  encoders.drive.counter_bits = params.integer("wheels/counter_bits");
  encoders.drive.max_wheel_speed_mps = params.number("wheels/max_speed");
  encoders.signed_counters = params.boolean("wheels/signed_counters");
  encoders.left_start_ticks = params.integer("wheels/left_start");
  encoders.right_start_ticks = params.integer("wheels/right_start");
  encoders.noise.independent_k_m = params.number("wheels/noise_independent");
  encoders.noise.common_k_m = params.number("wheels/noise_common");
  encoders.left_radius_factor = params.number("faults/left_radius_factor");
  encoders.right_radius_factor = params.number("faults/right_radius_factor");
  return encoders;
}

std::vector<core::TimeSpan> spansFrom(const std::vector<std::vector<double>>& rows) {
  std::vector<core::TimeSpan> spans;
  for (const std::vector<double>& row : rows) spans.push_back({row[0], row[1]});
  return spans;
}

core::RobotFaults readFaults(ParamReader& params) {
  core::RobotFaults faults;
  faults.occlusions = spansFrom(params.rows("faults/occlusions", 2));
  faults.lost_ticks = spansFrom(params.rows("faults/lost_ticks", 2));
  for (const auto& row : params.rows("faults/counter_resets", 1)) {
    faults.counter_resets_s.push_back(row[0]);
  }
  const auto readSlips = [&](const std::string& name, core::WheelSlip::Wheel wheel) {
    for (const auto& row : params.rows(name, 3)) {
      faults.slips.push_back({{row[0], row[1]}, wheel, row[2]});
    }
  };
  readSlips("faults/left_slips", core::WheelSlip::Wheel::kLeft);
  readSlips("faults/right_slips", core::WheelSlip::Wheel::kRight);
  return faults;
}

/// Steps between two events of `rate_hz`; an error unless it is a whole number.
int stepsBetween(ParamReader& params, const std::string& name, double step_rate_hz) {
  constexpr double kRounding = 1e-6;  // of a quotient of decimal numbers
  const double rate_hz = params.number(name);
  const double steps = step_rate_hz / rate_hz;
  if (steps >= 0.5 && steps <= std::numeric_limits<int>::max() &&
      std::abs(steps - std::round(steps)) <= kRounding * steps) {
    return static_cast<int>(std::lround(steps));
  }
  params.addError("parameter " + name +
                  " must be trajectory/step_rate divided by a whole number, but is " +
                  std::to_string(rate_hz));
  return 1;
}

core::Pose2 readPose(ParamReader& params, const std::string& group) {
  const double x_m = params.number(group + "/x");
  const double y_m = params.number(group + "/y");
  const double yaw_rad = params.number(group + "/yaw");
  core::Requirements require;
  require.between(group + "/yaw", yaw_rad, -core::plausible::kTurn_rad, core::plausible::kTurn_rad);
  params.addErrors(require.errors());
  return {{x_m, y_m}, core::wrapAngle(yaw_rad)};
}

core::RobotConfig readRobot(ParamReader& params, std::uint64_t seed) {
  core::RobotConfig robot;
  robot.encoders = readEncoders(params);
  robot.separation_factor = params.number("faults/separation_factor");
  robot.stamp_latency_s = params.number("faults/stamp_latency");
  robot.faults = readFaults(params);
  robot.base_from_sensor = readPose(params, "mount");
  robot.world_from_start = readPose(params, "start");
  const double step_rate_hz = params.number("trajectory/step_rate");
  robot.step_s = 1.0 / step_rate_hz;
  robot.steps_per_reading = stepsBetween(params, "wheels/rate", step_rate_hz);
  robot.steps_per_bearing = stepsBetween(params, "camera/rate", step_rate_hz);
  robot.seed = seed;
  return robot;
}

}  // namespace

std::vector<std::string> SimulatedClockConfig::validate() const {
  core::Requirements require;
  require.between("clock/rate", rate, core::plausible::kRarest_hz,
                  core::plausible::kMostFrequent_hz);
  require.that(publish == ros::Time::isSimTime(),
               publish ? "clock/publish is true, but /use_sim_time is not: nobody would listen"
                       : "clock/publish is false, but /use_sim_time is true: nobody would tell "
                         "the time");
  return require.errors();
}

std::vector<std::string> DrivingConfig::validate() const {
  core::Requirements require;
  require.add(trajectory.validate());
  require.between("trajectory/duration", duration_s, 0.0, core::plausible::kLongest_s);
  require.between("trajectory/command_timeout", command_timeout_s, core::plausible::kBriefest_s,
                  core::plausible::kLongest_s);
  require.that(!stops_at_end || duration_s > 0.0,
               "trajectory/at_end is stop, but trajectory/duration is 0: there is no end");
  return require.errors();
}

std::vector<std::string> SimulatedFrames::validate() const {
  core::Requirements require;
  require.that(!world.empty(), "frames/world must not be empty");
  require.that(!base.empty(), "frames/base must not be empty");
  require.that(!sensor.empty(), "frames/sensor must not be empty");
  return require.errors();
}

SimulationNodeConfig readSimulationNodeConfig(ParamReader params) {
  const int seed = params.integer("world/seed");
  const auto unsigned_seed = static_cast<std::uint64_t>(seed);
  SimulationNodeConfig config;
  config.clock = {params.boolean("clock/publish"), params.number("clock/rate")};
  config.frames = {params.text("frames/world"), params.text("frames/base"),
                   params.text("frames/sensor")};
  config.driving = readDriving(params, unsigned_seed);
  config.robot = readRobot(params, unsigned_seed);
  config.mount_height_m = params.number("mount/z");
  config.seed = unsigned_seed;
  config.scene = readScene(params, unsigned_seed);
  config.renderer = readRenderer(params, unsigned_seed);

  core::Requirements require;
  require.that(seed >= 0, "world/seed must not be negative, but is " + std::to_string(seed));
  require.add(config.clock.validate());
  require.add(config.frames.validate());
  require.add(config.driving.validate());
  require.add(config.robot.validate());
  require.between("mount/z", config.mount_height_m, -core::plausible::kFarthest_m,
                  core::plausible::kFarthest_m);
  require.add(config.scene.validate());
  require.add(config.renderer.validate());
  params.addErrors(require.errors());
  params.throwIfAnyError();
  return config;
}

}  // namespace bearing_calibration_ros
