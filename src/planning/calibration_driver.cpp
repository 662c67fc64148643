#include "bearing_calibration/planning/calibration_driver.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/planning/drive_script.h"

namespace bearing_calibration::core {
namespace {

/// Estimates are at most so old when they are carried on to now: what comes later is no estimate.
constexpr double kTrack_s = 10.0;
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

DriveEstimate DriveEstimate::from(const CalibrationResult& result) {
  DriveEstimate estimate{result.stamp, result.state, std::nullopt};
  if (result.cartesian_state) estimate.robot = {*result.cartesian_state, result.robot_errors};
  return estimate;
}

class CalibrationDriver::Impl {
 public:
  Impl(const DriveConfig& config, const DriveGoal& goal, Stamp now, const WheelSpeeds& moving)
      : command_(moving),
        has_stood_(isStanding(moving)),
        config_(validated(config)),
        goal_(validated(goal)),
        planner_(config.planner, config.limits, config.sensing, config.region),
        script_(goal.motion),
        track_(config.limits.wheel_separation_m, config.sensing.wheel_noise,
               durationFromSeconds(kTrack_s)),
        began_(now),
        last_steered_(now),
        last_travel_(now),
        last_bearing_(now),
        last_estimate_(now) {}

  void addTravel(const WheelTravel& travel, Stamp received) {
    last_travel_ = received;
    if (!track_.empty() && travel.stamp <= track_.newest()) return;
    if (!track_.empty()) {
      const WheelDisplacement wheels{travel.left_m - travelled_.left_m,
                                     travel.right_m - travelled_.right_m};
      const Arc arc = arcFromWheels(wheels, config_.limits.wheel_separation_m);
      if (has_stood_) start_from_base_ = start_from_base_ * arc.start_from_end;
      path_m_ += 0.5 * std::abs(wheels.left_m + wheels.right_m);
      turned_rad_ += (wheels.right_m - wheels.left_m) / config_.limits.wheel_separation_m;
    }
    travelled_ = {travel.left_m, travel.right_m};
    track_.add(travel);
    useEstimate();
  }

  void noteBearing(Stamp received) { last_bearing_ = received; }

  void addEstimate(const DriveEstimate& estimate, Stamp received) {
    last_estimate_ = received;
    if (estimate.state == CalibrationState::kConverged) end(DriveEnd::kConverged);
    if (!estimate.robot) known_.reset();
    const bool is_news = estimate.robot && (!known_ || estimate.stamp > known_->stamp);
    if (!is_news) return;
    waiting_ = estimate;
    useEstimate();
  }

  void end(DriveEnd reason) {
    if (ended_ == DriveEnd::kNone) ended_ = reason;
  }

  WheelSpeeds steer(Stamp now) {
    const double period_s = std::max(0.0, secondsFromDuration(now - last_steered_));
    last_steered_ = now;
    watch(now);
    has_stood_ = has_stood_ || isStanding(command_);
    if (ended_ == DriveEnd::kNone) {
      if (follower_ && follower_->done()) follower_.reset();
      if (!follower_ && has_stood_) decide();
      keepAway();
    }
    command_ = ended_ == DriveEnd::kNone && follower_
                   ? follower_->steer(travelled_, command_, period_s)
                   : braked(command_, config_.limits, period_s);
    return command_;
  }

  std::vector<Pose2> wayAhead() const {
    std::vector<Pose2> way{start_from_base_};
    if (!follower_ || ended_ != DriveEnd::kNone) return way;
    way.push_back(poseAfter(follower_->remaining(travelled_), way.back()));
    if (plan_) way.push_back(poseAfter(plan_->next, way.back()));
    return way;
  }

  DriveEnd ended_ = DriveEnd::kNone;
  WheelSpeeds command_;
  bool has_stood_;  ///< where it does so first is the start
  Pose2 start_from_base_;
  double path_m_ = 0.0;
  std::optional<PlannedPrimitive> plan_;
  double timeSeconds() const { return secondsFromDuration(last_steered_ - began_); }

 private:
  void watch(Stamp now) {
    if (isOver(last_travel_, config_.timeouts.ticks_s, now)) end(DriveEnd::kTicksLost);
    if (isOver(last_bearing_, config_.timeouts.bearings_s, now)) end(DriveEnd::kLightLost);
    if (isOver(last_estimate_, config_.timeouts.estimate_s, now)) end(DriveEnd::kEstimateLost);
    if (config_.region.clearance(start_from_base_.position_m) < 0.0) end(DriveEnd::kLeftRegion);
    if (follower_ && follower_->isDisobeyed(travelled_)) end(DriveEnd::kWheelsDisobeyed);
    if (secondsFromDuration(now - began_) > goal_.max_time_s) end(DriveEnd::kTimeOver);
    if (path_m_ > goal_.max_path_m) end(DriveEnd::kPathOver);
  }

  /// An estimate may be ahead of the wheel readings that have come here: it waits for them.
  void useEstimate() {
    if (!waiting_ || !track_.covers(waiting_->stamp)) return;
    track_.anchorAt(waiting_->stamp);
    known_ = waiting_;
    waiting_.reset();
  }

  /// The estimate carried on to now.
  std::optional<RobotEstimate> estimateNow() const {
    if (!known_) return std::nullopt;
    return movedBy(track_.motionTo(track_.newest()), *known_->robot);
  }

  /// Scripts are driven as they are printed, past a light that a person has put there.
  bool isAllowed(const MotionPrimitive& primitive,
                 const std::optional<RobotEstimate>& estimate) const {
    if (!planner_.staysInside(primitive, start_from_base_)) return false;
    if (!estimate) return true;
    return isPlanned() ? planner_.keepsAway(primitive, estimate->cartesian)
                       : !planner_.isSurelyTooNear(primitive, estimate->cartesian);
  }
  bool isPlanned() const { return goal_.motion == DriveMotion::kOptimal; }

  void decide() {
    plan_.reset();
    if (track_.empty()) return;  // the first reading says where the wheels stand
    const std::optional<RobotEstimate> estimate = estimateNow();
    if (isPlanned() && estimate) {
      plan_ = planner_.plan(*estimate, start_from_base_);
      if (plan_) follower_.emplace(plan_->primitive, config_.limits, travelled_);
    } else {
      const auto allowed = [&](const MotionPrimitive& primitive) {
        return isAllowed(primitive, estimate);
      };
      const std::optional<MotionPrimitive> primitive = script_.next(turned_rad_, allowed);
      if (primitive) follower_.emplace(*primitive, config_.limits, travelled_);
    }
    if (!follower_) end(DriveEnd::kNoWay);
  }

  /// The estimate goes on growing during a primitive: what is left of it must still be allowed. A
  /// plan is made anew then; a script would be another one without a part of it.
  void keepAway() {
    const std::optional<RobotEstimate> estimate = estimateNow();
    if (!follower_ || !estimate) return;
    if (isAllowed(follower_->remaining(travelled_), estimate)) return;
    if (!isPlanned()) end(DriveEnd::kNoWay);
    follower_->abandon();
  }

  DriveConfig config_;
  DriveGoal goal_;
  MotionPlanner planner_;
  DriveScript script_;
  OdometryTrack track_;  ///< anchored at known_'s stamp
  WheelDisplacement travelled_;
  double turned_rad_ = 0.0;               ///< since the start, full turns too
  std::optional<DriveEstimate> waiting_;  ///< for the readings that cover it
  std::optional<DriveEstimate> known_;
  std::optional<PrimitiveFollower> follower_;
  Stamp began_, last_steered_, last_travel_, last_bearing_, last_estimate_;
};

CalibrationDriver::CalibrationDriver(const DriveConfig& config, const DriveGoal& goal, Stamp now,
                                     const WheelSpeeds& moving)
    : impl_(std::make_unique<Impl>(config, goal, now, moving)) {}
CalibrationDriver::~CalibrationDriver() = default;
CalibrationDriver::CalibrationDriver(CalibrationDriver&&) noexcept = default;
CalibrationDriver& CalibrationDriver::operator=(CalibrationDriver&&) noexcept = default;

void CalibrationDriver::addTravel(const WheelTravel& travel, Stamp received) {
  impl_->addTravel(travel, received);
}
void CalibrationDriver::noteBearing(Stamp received) { impl_->noteBearing(received); }
void CalibrationDriver::addEstimate(const DriveEstimate& estimate, Stamp received) {
  impl_->addEstimate(estimate, received);
}
void CalibrationDriver::end(DriveEnd reason) { impl_->end(reason); }
WheelSpeeds CalibrationDriver::steer(Stamp now) { return impl_->steer(now); }
DriveEnd CalibrationDriver::ended() const { return impl_->ended_; }
const WheelSpeeds& CalibrationDriver::command() const { return impl_->command_; }
bool CalibrationDriver::standing() const { return isStanding(impl_->command_); }
double CalibrationDriver::timeSeconds() const { return impl_->timeSeconds(); }
double CalibrationDriver::pathMeters() const { return impl_->path_m_; }
const Pose2& CalibrationDriver::startFromBase() const { return impl_->start_from_base_; }
std::vector<Pose2> CalibrationDriver::wayAhead() const { return impl_->wayAhead(); }
const std::optional<PlannedPrimitive>& CalibrationDriver::plan() const { return impl_->plan_; }

}  // namespace bearing_calibration::core
