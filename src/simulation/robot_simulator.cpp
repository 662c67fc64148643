#include "bearing_calibration/simulation/robot_simulator.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace bearing_calibration::core {
namespace {

bool anyContains(const std::vector<TimeSpan>& spans, double time_s) {
  return std::any_of(spans.begin(), spans.end(),
                     [time_s](const TimeSpan& span) { return span.contains(time_s); });
}

void checkSpan(Parameters& params, const std::string& name, const TimeSpan& span) {
  params.between(name + ": a start", span.start_s, 0.0, plausible::kLongest_s);
  params.between(name + ": a duration", span.duration_s, 0.0, plausible::kLongest_s);
}

void declareSpans(Parameters& params, const std::string& name, std::vector<TimeSpan>& spans) {
  params.list(name, 2, spans, [](const auto& row) { return TimeSpan{row[0], row[1]}; });
  for (const TimeSpan& span : spans) checkSpan(params, name, span);
}

void declarePlace(Parameters& params, const std::string& group, Pose2& pose) {
  using plausible::kFarthest_m, plausible::kTurn_rad;
  params.number(group + "/x", pose.position_m.x(), -kFarthest_m, kFarthest_m);
  params.number(group + "/y", pose.position_m.y(), -kFarthest_m, kFarthest_m);
  params.number(group + "/yaw", pose.yaw_rad, -kTurn_rad, kTurn_rad);
  pose.yaw_rad = wrapAngle(pose.yaw_rad);
}

}  // namespace

void RobotFaults::declare(Parameters& params) {
  declareSpans(params, "faults/occlusions", occlusions);
  declareSpans(params, "faults/lost_ticks", lost_ticks);
  params.list("faults/counter_resets", 1, counter_resets_s,
              [](const auto& row) { return row.front(); });
  for (const double moment_s : counter_resets_s) {
    params.between("faults/counter_resets", moment_s, 0.0, plausible::kLongest_s);
  }
  for (const auto& [name, wheel] : {std::pair("faults/left_slips", WheelSlip::Wheel::kLeft),
                                    std::pair("faults/right_slips", WheelSlip::Wheel::kRight)}) {
    params.list(name, 3, slips, [side = wheel](const auto& row) {
      return WheelSlip{{row[0], row[1]}, side, row[2]};
    });
  }
  for (const WheelSlip& slip : slips) {
    const bool is_left = slip.wheel == WheelSlip::Wheel::kLeft;
    const std::string name = is_left ? "faults/left_slips" : "faults/right_slips";
    checkSpan(params, name, slip.when);
    params.between(name + ": an excess", slip.excess, -plausible::kLargestRatio,
                   plausible::kLargestRatio);
  }
}

void RobotConfig::declare(Parameters& params) {
  constexpr double kShortestStep_s = 1e-5;
  constexpr double kLongestStep_s = 1.0;
  using plausible::kLargestRatio, plausible::kLongest_s;
  encoders.declare(params);
  sensor.declare(params);
  faults.declare(params);
  declarePlace(params, "mount", base_from_sensor);
  declarePlace(params, "start", world_from_start);
  params.number("faults/separation_factor", separation_factor, 1.0 / kLargestRatio, kLargestRatio);
  params.number("faults/stamp_latency", stamp_latency_s, -kLongest_s, kLongest_s);
  params.between("the step (1 / trajectory/step_rate)", step_s, kShortestStep_s, kLongestStep_s);
  params.that(steps_per_reading > 0, "there must be at least one step in a reading's period");
  params.that(steps_per_bearing > 0, "there must be at least one step in a bearing's period");
  params.that(isStamped(start), "the start must have a stamp greater than zero");
}

RobotSimulator::RobotSimulator(const RobotConfig& config, std::vector<Light> lights,
                               Trajectory trajectory)
    : config_(validated(config)),
      lights_(std::move(lights)),
      trajectory_(std::move(trajectory)),
      encoders_(config.encoders, config.seed),
      sensor_(config.sensor, config.seed),
      wheel_separation_m_(config.encoders.drive.wheel_separation_m * config.separation_factor),
      step_(durationFromSeconds(config.step_s)),
      world_from_base_(config.world_from_start) {
  if (!trajectory_) throw std::invalid_argument("a simulated robot needs a trajectory");
}

double RobotSimulator::timeSeconds() const { return secondsFromDuration(steps_ * step_); }

Stamp RobotSimulator::now() const { return config_.start + steps_ * step_; }

bool RobotSimulator::lightsOccluded() const {
  return anyContains(config_.faults.occlusions, timeSeconds());
}

void RobotSimulator::step() {
  const WheelDisplacement ground = trajectory_(config_.step_s);
  world_from_base_ = world_from_base_ * arcFromWheels(ground, wheel_separation_m_).start_from_end;
  encoders_.roll(turned(ground));
  for (Light& light : lights_) light.position_m += config_.step_s * light.velocity_mps;
  const double before_s = timeSeconds();
  ++steps_;
  for (double reset_s : config_.faults.counter_resets_s) {
    if (reset_s > before_s && reset_s <= timeSeconds()) encoders_.resetCounters();
  }
}

WheelDisplacement RobotSimulator::turned(const WheelDisplacement& ground) const {
  WheelDisplacement turned = ground;
  for (const WheelSlip& slip : config_.faults.slips) {
    if (!slip.when.contains(timeSeconds())) continue;
    double& wheel_m = slip.wheel == WheelSlip::Wheel::kLeft ? turned.left_m : turned.right_m;
    wheel_m *= 1.0 + slip.excess;
  }
  return turned;
}

std::optional<WheelCounts> RobotSimulator::readTicks() const {
  const bool is_due = steps_ % config_.steps_per_reading == 0;
  if (!is_due || anyContains(config_.faults.lost_ticks, timeSeconds())) return std::nullopt;
  return encoders_.read(now());
}

std::optional<BearingSet> RobotSimulator::readBearings() {
  if (!bearingsDue()) return std::nullopt;
  const Stamp stamp = now() + durationFromSeconds(config_.stamp_latency_s);
  BearingSet bearings = sensor_.measure(lights_, worldFromSensor(), stamp);
  if (lightsOccluded()) bearings.candidates.clear();
  return bearings;
}

SimulatedRecord record(RobotSimulator* simulator, double duration_s) {
  SimulatedRecord record;
  const Stamp end = simulator->now() + durationFromSeconds(duration_s);
  while (true) {
    if (const auto ticks = simulator->readTicks()) record.ticks.push_back(*ticks);
    if (auto bearings = simulator->readBearings()) {
      record.bearings.push_back(std::move(*bearings));
      record.world_from_base.push_back(simulator->worldFromBase());
    }
    if (simulator->now() >= end) return record;
    simulator->step();
  }
}

}  // namespace bearing_calibration::core
