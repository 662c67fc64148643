#include "bearing_calibration_ros/simulation_params.h"

#include <ros/time.h>

#include <cmath>
#include <limits>

namespace bearing_calibration_ros {
namespace {

using namespace core::plausible;

/// A rate [Hz] as the number of steps between two of its events.
void declareRate(const std::string& name, double step_rate_hz, int& steps_between,
                 core::Parameters& params) {
  constexpr double kRounding = 1e-6;  // of a quotient of decimal numbers
  double rate_hz = step_rate_hz / steps_between;
  params.read(name, rate_hz);
  const double steps = step_rate_hz / rate_hz;
  const bool is_whole = steps >= 0.5 && steps <= std::numeric_limits<int>::max() &&
                        std::abs(steps - std::round(steps)) <= kRounding * steps;
  params.that(is_whole, name + " must be trajectory/step_rate divided by a whole number, but is " +
                            std::to_string(rate_hz));
  if (is_whole) steps_between = static_cast<int>(std::lround(steps));
}

}  // namespace

void SimulatedClockConfig::declare(core::Parameters& params) {
  params.read("clock/publish", publish);
  params.number("clock/rate", rate, kRarest_hz, kMostFrequent_hz);
  params.that(publish == ros::Time::isSimTime(),
              publish ? "clock/publish is true, but /use_sim_time is not: nobody would listen"
                      : "clock/publish is false, but /use_sim_time is true: nobody would tell "
                        "the time");
}

void DrivingConfig::declare(core::Parameters& params) {
  std::vector<std::string> kinds = core::trajectoryNames();
  std::size_t kind = follows_commands ? kinds.size() : static_cast<std::size_t>(trajectory.kind);
  kinds.emplace_back("cmd_vel");
  params.choice("trajectory/kind", kinds, kind);
  follows_commands = kind == kinds.size() - 1;
  if (!follows_commands) trajectory.kind = static_cast<core::TrajectoryConfig::Kind>(kind);
  trajectory.declare(params);
  params.number("trajectory/duration", duration_s, 0.0, kLongest_s);
  params.number("trajectory/command_timeout", command_timeout_s, kBriefest_s, kLongest_s);
  params.choice("trajectory/at_end", {"hold", "stop"}, stops_at_end);
  params.that(!stops_at_end || duration_s > 0.0,
              "trajectory/at_end is stop, but trajectory/duration is 0: there is no end");
}

void SimulatedFrames::declare(core::Parameters& params) {
  for (const auto& [name, frame] :
       {std::pair("frames/world", &world), std::pair("frames/base", &base),
        std::pair("frames/sensor", &sensor)}) {
    params.read(name, *frame);
    params.notEmpty(name, *frame);
  }
}

void SimulationNodeConfig::declare(core::Parameters& params) {
  int whole_seed = 0;
  if (params.read("world/seed", whole_seed)) params.notNegative("world/seed", whole_seed);
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
  params.number("mount/z", mount_height_m, -kFarthest_m, kFarthest_m);
  scene.declare(params);
  renderer.declare(params);
}

}  // namespace bearing_calibration_ros
