#pragma once

#include <ros/time.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "bearing_calibration/simulation/image_renderer.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/scene.h"
#include "bearing_calibration/simulation/trajectory.h"
#include "bearing_calibration_ros/namespaces.h"
#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// Parameter group `clock`.
struct SimulatedClockConfig {
  bool publish = false;  ///< time is the simulation's own, sent to /clock; else it is wall time
  double rate = 1.0;     ///< simulated seconds in a second, when published

  void declare(core::Parameters& params) {
    params.read("clock/publish", publish);
    params.number("clock/rate", rate, core::plausible::kRarest_hz,
                  core::plausible::kMostFrequent_hz);
    params.that(publish == ros::Time::isSimTime(),
                publish ? "clock/publish is true, but /use_sim_time is not: nobody would listen"
                        : "clock/publish is false, but /use_sim_time is true: nobody would "
                          "publish the time");
  }
};

/// Parameter group `trajectory`.
struct DrivingConfig {
  bool follows_commands = false;  ///< of cmd_vel; else drives `trajectory`
  core::TrajectoryConfig trajectory;
  double duration_s = 0.0;         ///< the robot stands still afterwards; 0 is without end
  bool stops_at_end = false;       ///< and the simulation falls silent
  double command_timeout_s = 0.0;  ///< a command older than this no longer moves the robot

  void declare(core::Parameters& params) {
    std::vector<std::string> kinds = core::trajectoryNames();
    std::size_t kind = follows_commands ? kinds.size() : static_cast<std::size_t>(trajectory.kind);
    kinds.emplace_back("cmd_vel");
    params.choice("trajectory/kind", kinds, kind);
    follows_commands = kind == kinds.size() - 1;
    if (!follows_commands) trajectory.kind = static_cast<core::TrajectoryConfig::Kind>(kind);
    trajectory.declare(params);
    params.number("trajectory/duration", duration_s, 0.0, core::plausible::kLongest_s);
    params.number("trajectory/command_timeout", command_timeout_s, core::plausible::kBriefest_s,
                  core::plausible::kLongest_s);
    params.choice("trajectory/at_end", {"hold", "stop"}, stops_at_end);
    params.that(!stops_at_end || duration_s > 0.0,
                "trajectory/at_end is stop, but trajectory/duration is 0: there is no end");
  }
};

/// Parameter group `frames`.
struct SimulatedFrames {
  std::string world;
  std::string base;
  std::string sensor;

  void declare(core::Parameters& params) {
    for (const auto& [name, frame] :
         {std::pair("frames/world", &world), std::pair("frames/base", &base),
          std::pair("frames/sensor", &sensor)}) {
      params.read(name, *frame);
      params.notEmpty(name, *frame);
    }
  }
};

/// Everything that the simulation nodelet reads from its private parameters:
/// config/simulation.yaml.
struct SimulationNodeConfig {
  SimulatedClockConfig clock;
  SimulatedFrames frames;
  DrivingConfig driving;
  core::RobotConfig robot;
  double mount_height_m = 0.0;  ///< of the sensor over the base frame
  core::SceneConfig scene;
  core::RendererConfig renderer;  ///< its holders are drawn with the scene
  std::uint64_t seed = 0;         ///< of the scene and of every noise

  void declare(core::Parameters& params) {
    int whole_seed = 0;
    params.integer("world/seed", whole_seed, 0, std::numeric_limits<int>::max());
    seed = robot.seed = driving.trajectory.seed = scene.room.seed = renderer.seed =
        static_cast<std::uint64_t>(whole_seed);
    double step_rate_hz = 1.0 / robot.step_s;
    params.read("trajectory/step_rate", step_rate_hz);
    robot.step_s = 1.0 / step_rate_hz;
    declareRate("wheels/rate", step_rate_hz, robot.steps_per_reading, params);
    declareRate("camera/rate", step_rate_hz, robot.steps_per_bearing, params);
    clock.declare(params);
    frames.declare(params);
    driving.declare(params);
    robot.declare(params);
    params.number("mount/z", mount_height_m, -core::plausible::kFarthest_m,
                  core::plausible::kFarthest_m);
    scene.declare(params);
    renderer.declare(params);
  }

 private:
  /// A rate [Hz] as the number of steps between two of its events.
  static void declareRate(const std::string& name, double step_rate_hz, int& steps_between,
                          core::Parameters& params) {
    constexpr double kRounding = 1e-6;  // of a quotient of decimal numbers
    double rate_hz = step_rate_hz / steps_between;
    params.read(name, rate_hz);
    const double steps = step_rate_hz / rate_hz;
    const bool is_whole = steps >= 0.5 && steps <= std::numeric_limits<int>::max() &&
                          std::abs(steps - std::round(steps)) <= kRounding * steps;
    params.that(is_whole, name +
                              " must be trajectory/step_rate divided by a whole number, but is " +
                              std::to_string(rate_hz));
    if (is_whole) steps_between = static_cast<int>(std::lround(steps));
  }
};

}  // namespace bearing_calibration_ros
