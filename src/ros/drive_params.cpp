#include "bearing_calibration_ros/drive_params.h"

#include <optional>
#include <stdexcept>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration_ros {
namespace {

core::PlannerConfig readPlanner(ParamReader& params) {
  using Block = core::PlannerConfig::Block;
  constexpr Block kBlocks[] = {Block::kMount, Block::kPosition, Block::kYaw};
  core::PlannerConfig planner;
  planner.block = kBlocks[params.choice("planner/block", {"mount", "position", "yaw"})];
  planner.light_distance_m = params.number("planner/light_distance");
  planner.light_sigmas = params.number("planner/light_sigmas");
  planner.region_margin_m = params.number("planner/region_margin");
  planner.max_straight_m = params.number("planner/max_straight");
  return planner;
}

core::Region readRegion(ParamReader& params) {
  core::Region region;
  region.radius_m = params.number("region/radius");
  for (const std::vector<double>& corner : params.rows("region/polygon", 2)) {
    region.polygon_m.emplace_back(corner[0], corner[1]);
  }
  return region;
}

core::DriveConfig readDrive(const WheelParams& wheels, ParamReader& params) {
  core::DriveConfig drive;
  drive.limits = {wheels.drive.wheel_separation_m, params.number("limits/wheel_speed"),
                  params.number("limits/wheel_acceleration")};
  drive.sensing = {wheels.noise, params.number("planner/bearing_stddev"),
                   params.number("planner/bearing_rate")};
  drive.planner = readPlanner(params);
  drive.region = readRegion(params);
  drive.timeouts = {params.number("timeouts/ticks"), params.number("timeouts/bearings"),
                    params.number("timeouts/estimate")};
  return drive;
}

}  // namespace

std::vector<std::string> DriveNodeConfig::validate() const {
  core::Requirements require;
  require.add(wheels.validate());
  require.add(wheels.drive.validate());
  require.add(drive.validate());
  constexpr double kLeastControl_hz = 1.0;
  constexpr double kMostControl_hz = 1000.0;
  constexpr double kLongestSilence_s = 60.0;  // a longer one is no dead man's button
  using core::DriveGoal;
  using core::plausible::kBriefest_s, core::plausible::kLongest_s,
      core::plausible::kLongestHistory_s;
  require.between("drive/max_time", default_goal.max_time_s, DriveGoal::kLeastTime_s,
                  DriveGoal::kMostTime_s);
  require.between("drive/max_path", default_goal.max_path_m, DriveGoal::kLeastPath_m,
                  DriveGoal::kMostPath_m);
  require.between("timeouts/enable", enable_timeout_s, 0.0, kLongestSilence_s);
  require.between("timeouts/obstacle", obstacle_timeout_s, 0.0, kLongestSilence_s);
  require.between("timeouts/clock", clock_timeout_s, kBriefest_s, kLongest_s);
  require.between("wheels/max_apart", wheels.max_apart_s, kBriefest_s, kLongestHistory_s);
  require.between("wheels/history", wheels.history_s, kBriefest_s, kLongestHistory_s);
  require.between("drive/control_rate", control_rate_hz, kLeastControl_hz, kMostControl_hz);
  require.that(!start_frame.empty(), "drive/start_frame must not be empty");
  require.that(drive.limits.max_speed_mps <= wheels.drive.max_wheel_speed_mps,
               "limits/wheel_speed must not be greater than wheels/max_speed: faster readings are "
               "refused");
  return require.errors();
}

DriveNodeConfig readDriveNodeConfig(ParamReader params) {
  DriveNodeConfig config;
  config.wheels = readWheels(params);
  config.drive = readDrive(config.wheels, params);
  config.default_goal = {
      static_cast<core::DriveMotion>(params.choice("drive/motion", core::motionNames())),
      params.number("drive/max_time"), params.number("drive/max_path")};
  config.clock_timeout_s = params.number("timeouts/clock");
  config.enable_timeout_s = params.number("timeouts/enable");
  config.obstacle_timeout_s = params.number("timeouts/obstacle");
  config.enable_required = params.boolean("enable/required");
  config.control_rate_hz = params.number("drive/control_rate");
  config.start_frame = params.text("drive/start_frame");
  params.addErrors(config.validate());
  params.throwIfAnyError();
  return config;
}

core::DriveGoal goalFrom(const std::string& motion, double max_time_s, double max_path_m,
                         const core::DriveGoal& default_goal) {
  core::DriveGoal goal = default_goal;
  if (!motion.empty()) {
    const std::optional<core::DriveMotion> named = core::motionNamed(motion);
    if (!named) {
      throw std::invalid_argument("motion must be optimal, dance or corner_light, but is '" +
                                  motion + "'");
    }
    goal.motion = *named;
  }
  if (max_time_s != 0.0) goal.max_time_s = max_time_s;
  if (max_path_m != 0.0) goal.max_path_m = max_path_m;
  return core::validated(goal);
}

}  // namespace bearing_calibration_ros
