#include "bearing_calibration/planning/calibration_driver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bearing_calibration/filter/motion_model.h"

namespace bearing_calibration::core {
namespace {

struct DriveEndWords {
  const char* name;
  const char* sentence;
};
constexpr std::array<DriveEndWords, 18> kDriveEndWords{{
    {"DRIVING", "the robot drives"},
    {"CONVERGED", "the calibration has converged"},
    {"CANCELLED", "the drive was cancelled"},
    {"DISABLED", "~enable is false: no drive until it is true"},
    {"OBSTACLE", "an obstacle was reported: clear the way, then start again"},
    {"TICKS_LOST", "no wheel readings: check the wheel driver"},
    {"LIGHT_LOST", "the light is not seen: check the lamp, the detector and what stands between"},
    {"ESTIMATE_LOST", "the calibration is silent: check its node"},
    {"CLOCK_LOST", "ROS time stood still or jumped: check /clock, or the computer's clock"},
    {"LEFT_REGION", "the robot has left its region: put it back, then start again"},
    {"NO_WAY", "every path leads too near to a light or out of the region: give more room"},
    {"WHEELS_DISOBEYED",
     "the wheels do not roll as commanded: check cmd_vel, and whether they are swapped"},
    {"TIME_OVER", "the time of this drive is over"},
    {"PATH_OVER", "the path of this drive is over"},
    {"SHUT_DOWN", "the drive node was asked to end"},
    {"ENABLE_LOST", "~enable is silent: its publisher must repeat it (timeouts/enable)"},
    {"OBSTACLE_LOST", "obstacle is silent: its publisher must repeat it (timeouts/obstacle)"},
    {"FAILED", "an error inside the drive node, which its log names"},
}};

/// Estimates are at most so old when they are carried on to now: what comes later is no estimate.
constexpr double kTrack_s = 10.0;
/// A turn on the spot brings the light into view. But one that is nearer to the base's centre than
/// the sensor is may be out of view in all of it, until the robot has driven on.
constexpr double kMostUnseen_rad = 3.0 * 2.0 * kPi;

bool isOver(Stamp last, double timeout_s, Stamp now) {
  return secondsFromDuration(now - last) > timeout_s;
}

}  // namespace

void DriveTimeouts::declare(Parameters& params) {
  using plausible::kBriefest_s, plausible::kLongest_s;
  params.number("timeouts/ticks", ticks_s, kBriefest_s, kLongest_s);
  params.number("timeouts/bearings", bearings_s, kBriefest_s, kLongest_s);
  params.number("timeouts/estimate", estimate_s, kBriefest_s, kLongest_s);
}

void DriveConfig::declare(Parameters& params) {
  limits.declare(params);
  sensing.declare(params);
  planner.declare(params);
  region.declare(params);
  timeouts.declare(params);
}

void DriveGoal::declare(Parameters& params) {
  params.between("max_time_s", max_time_s, kLeastTime_s, kMostTime_s);
  params.between("max_path_m", max_path_m, kLeastPath_m, kMostPath_m);
}

const char* nameOf(DriveEnd end) { return kDriveEndWords.at(static_cast<std::size_t>(end)).name; }
const char* describe(DriveEnd end) {
  return kDriveEndWords.at(static_cast<std::size_t>(end)).sentence;
}

CalibrationDriver::CalibrationDriver(const DriveConfig& config, const DriveGoal& goal, Stamp now,
                                     const WheelSpeeds& moving)
    : config_(validated(config)),
      goal_(validated(goal)),
      planner_(config.planner, config.limits, config.sensing, config.region),
      script_(goal.motion),
      track_(config.limits.wheel_separation_m, config.sensing.wheel_noise,
             durationFromSeconds(kTrack_s)),
      began_(now),
      command_(moving),
      has_stood_(isStanding(moving)) {}

void CalibrationDriver::addTravel(const WheelTravel& travel, Stamp received) {
  last_travel_ = received;
  if (!track_.empty() && travel.stamp <= track_.newest()) return;
  if (!track_.empty()) {
    const WheelDisplacement wheels{travel.left_m - travelled_.left_m,
                                   travel.right_m - travelled_.right_m};
    const Arc arc = arcFromWheels(wheels, config_.limits.wheel_separation_m);
    if (has_stood_) start_from_base_ = start_from_base_ * arc.start_from_end;
    path_m_ += 0.5 * std::abs(wheels.left_m + wheels.right_m);
    const double turn_rad = (wheels.right_m - wheels.left_m) / config_.limits.wheel_separation_m;
    turned_rad_ += turn_rad;
    turned_unseen_rad_ += std::abs(turn_rad);
  }
  travelled_ = {travel.left_m, travel.right_m};
  track_.add(travel);
  useEstimate();
}

/// Of a field of view that no sensor has nothing is used, as in the calibration: LIGHT_LOST.
void CalibrationDriver::addBearings(const BearingSet& bearings, Stamp received) {
  if (!bearings.view.isPossible()) return;
  last_image_ = received;
  view_ = bearings.view;
  planner_.setView(view_);
  const auto mayBeTheLight = [this](const Bearing& candidate) {
    const double probability = candidate.overallProbability();
    // zero: known to be another one
    return probability > 0.0 && probability >= config_.min_probability;
  };
  const std::vector<Bearing>& candidates = bearings.candidates;
  if (std::none_of(candidates.begin(), candidates.end(), mayBeTheLight)) return;
  last_bearing_ = received;
  turned_unseen_rad_ = 0.0;
}

void CalibrationDriver::addEstimate(const DriveEstimate& estimate, Stamp received) {
  last_estimate_ = received;
  is_calibration_heard_ = true;
  if (estimate.state == CalibrationState::kConverged) end(DriveEnd::kConverged);
  if (!estimate.robot) {  // taken back, and with it one that still waits
    is_taken_back_ = true;
    waiting_.reset();
  }
  const bool is_news =
      estimate.robot && (!known_ || is_taken_back_ || estimate.stamp > known_->stamp);
  if (!is_news) return;
  waiting_ = {estimate.stamp, *estimate.robot};
  planner_.setNearness(estimate.nearness_stddev_m);
  useEstimate();
}

/// An estimate may be ahead of the wheel readings that have come here: it waits for them.
void CalibrationDriver::useEstimate() {
  if (!waiting_ || !track_.covers(waiting_->stamp)) return;
  track_.anchorAt(waiting_->stamp);
  known_ = waiting_;
  is_taken_back_ = false;
  waiting_.reset();
}

/// The estimate carried on to now.
std::optional<StateEstimate> CalibrationDriver::estimateNow() const {
  if (!known_) return std::nullopt;
  StateEstimate estimate = known_->estimate;
  const OdometryIncrement motion = track_.motionTo(track_.newest());
  propagate(motion, &estimate);
  return estimate;
}

void CalibrationDriver::end(DriveEnd reason) {
  if (ended_ == DriveEnd::kNone) ended_ = reason;
}

WheelSpeeds CalibrationDriver::steer(Stamp now, double real_period_s) {
  const double period_s = std::max(0.0, secondsFromDuration(now - last_steered_));
  last_steered_ = now;
  time_s_ += period_s;
  watch(now, period_s, period_s - real_period_s);
  has_stood_ = has_stood_ || isStanding(command_);
  if (ended_ == DriveEnd::kNone) {
    if (follower_ && follower_->done()) follower_.reset();
    if (!follower_ && has_stood_) decide();
    keepAway();
  }
  command_ = ended_ == DriveEnd::kNone && follower_
                 ? follower_->steer(travelled_, command_, period_s)
                 : braked(command_, config_.limits, std::max(period_s, real_period_s));
  return command_;
}

/// Whether the light should be seen now: by a sensor that sees a part of a turn only where it is
/// expected in view, and in any case after some turns.
bool CalibrationDriver::isLightDue() const {
  if (!view_.isLimited() || turned_unseen_rad_ > kMostUnseen_rad) return true;
  const std::optional<StateEstimate> estimate = estimateNow();
  return estimate && !is_taken_back_ && chanceInView(view_, *estimate) > 0.5;
}

void CalibrationDriver::watch(Stamp now, double period_s, double jump_s) {
  const DriveTimeouts& timeouts = config_.timeouts;
  if (jump_s > std::max({timeouts.ticks_s, timeouts.bearings_s, timeouts.estimate_s})) {
    end(DriveEnd::kClockLost);  // all inputs would seem to be lost
  }
  if (!isLightDue()) last_bearing_ += durationFromSeconds(period_s);
  if (isOver(last_travel_, timeouts.ticks_s, now)) end(DriveEnd::kTicksLost);
  for (const Stamp last : {last_image_, last_bearing_}) {
    if (isOver(last, timeouts.bearings_s, now)) end(DriveEnd::kLightLost);
  }
  if (isOver(last_estimate_, timeouts.estimate_s, now)) end(DriveEnd::kEstimateLost);
  if (config_.region.clearance(start_from_base_.position_m) < 0.0) end(DriveEnd::kLeftRegion);
  if (follower_ && follower_->isDisobeyed(travelled_)) end(DriveEnd::kWheelsDisobeyed);
  if (isOver(began_, goal_.max_time_s, now)) end(DriveEnd::kTimeOver);
  if (path_m_ > goal_.max_path_m) end(DriveEnd::kPathOver);
}

/// Scripts are driven as they are printed, past a light that a person has put there.
bool CalibrationDriver::isAllowed(const MotionPrimitive& primitive,
                                  const std::optional<StateEstimate>& estimate) const {
  return planner_.staysInside(primitive, start_from_base_) &&
         (!estimate || planner_.keepsAway(primitive, *estimate, !isPlanned()));
}

void CalibrationDriver::decide() {
  plan_.reset();
  // The first reading says where the wheels stand, the first estimate that it is of use to move.
  if (track_.empty() || !is_calibration_heard_) return;
  const std::optional<StateEstimate> estimate = estimateNow();
  std::optional<MotionPrimitive> next;
  if (isPlanned() && estimate && !is_taken_back_) {
    plan_ = planner_.plan(*estimate, start_from_base_);
    if (plan_) next = plan_->primitive;
  } else {
    next = script_.next(turned_rad_, [&](const MotionPrimitive& primitive) {
      return isAllowed(primitive, estimate);
    });
  }
  if (next) {
    follower_.emplace(*next, config_.limits, travelled_);
  } else {
    end(DriveEnd::kNoWay);
  }
}

/// The estimate goes on growing during a primitive: what is left of it must still be allowed. A
/// plan is made anew then; a script would be another one without a part of it.
void CalibrationDriver::keepAway() {
  const std::optional<StateEstimate> estimate = estimateNow();
  if (!follower_ || !estimate) return;
  if (isAllowed(follower_->remaining(travelled_), estimate)) return;
  if (!isPlanned()) end(DriveEnd::kNoWay);
  follower_->abandon();
}

std::vector<Pose2> CalibrationDriver::wayAhead() const {
  std::vector<Pose2> way{start_from_base_};
  if (!follower_ || ended_ != DriveEnd::kNone) return way;
  way.push_back(poseAfter(follower_->remaining(travelled_), way.back()));
  if (plan_) way.push_back(poseAfter(plan_->next, way.back()));
  return way;
}

}  // namespace bearing_calibration::core
