#include "bearing_calibration/calibration/calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/calibration/bearing_input.h"
#include "bearing_calibration/calibration/bearing_queue.h"
#include "bearing_calibration/calibration/convergence_judge.h"
#include "bearing_calibration/calibration/driver_advice.h"
#include "bearing_calibration/calibration/initializer.h"
#include "bearing_calibration/calibration/light_picker.h"
#include "bearing_calibration/calibration/light_start.h"
#include "bearing_calibration/calibration/mount_tracker.h"
#include "bearing_calibration/common/validated.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"

namespace bearing_calibration {
namespace {

constexpr Duration kAttemptInterval = std::chrono::seconds(1);  // an attempt takes milliseconds

MountEstimate mountFromGuess(const StartConfig& guess) {
  const double position_variance = guess.position_stddev_m * guess.position_stddev_m;
  MountEstimate mount;
  mount.mean << guess.x_m, guess.y_m, guess.yaw_rad;
  mount.covariance.diagonal() << position_variance, position_variance,
      guess.yaw_stddev_rad * guess.yaw_stddev_rad;
  return mount;
}

}  // namespace

class Calibrator::Impl {
 public:
  explicit Impl(const CalibratorConfig& config)
      : config_(validated(config)),
        odometer_(config.drive),
        track_(config.drive.wheel_separation_m, config.wheel_noise,
               durationFromSeconds(config.tick_history_s)),
        queue_(static_cast<std::size_t>(config.bearings.max_waiting)),
        initializer_(config.initializer) {}

  const CalibratorConfig& config() const { return config_; }

  template <class Reading>
  InputOutcome addReading(const Reading& reading, Stamp received) {
    InputOutcome outcome = checkStamp(reading.stamp, received, config_.bearings.max_future_s);
    if (outcome.accepted()) outcome = odometer_.add(reading);
    ++counts_.tick_inputs[outcome.status];
    if (odometer_.travel() && (track_.empty() || odometer_.travel()->stamp > track_.newest())) {
      followTravel(*odometer_.travel());
      fuseCovered();
    }
    return outcome;
  }

  InputOutcome addBearings(const BearingSet& bearings, Stamp received) {
    const InputOutcome stamp = checkStamp(bearings.stamp, received, config_.bearings.max_future_s);
    if (!stamp.accepted()) return countBearings(stamp);
    if (paused_) return countBearings({InputStatus::kIgnoredPaused, 0.0});
    CheckedBearings checked = checkBearings(bearings, config_.bearings);
    if (last_fused_ && checked.bearings.stamp <= *last_fused_) {
      return countBearings({InputStatus::kStampNotAfterLast,
                            secondsFromDuration(*last_fused_ - checked.bearings.stamp)});
    }
    for (const InputOutcome& refused : checked.refused) countBearings(refused);
    if (!queue_.add(std::move(checked.bearings))) {
      countBearings({InputStatus::kQueueFull, static_cast<double>(config_.bearings.max_waiting)});
    }
    fuseCovered();
    return checked.refused.empty() ? countBearings({}) : checked.refused.front();
  }

  std::optional<BearingPrediction> predictBearing(Stamp stamp) const {
    if (!tracker_) return std::nullopt;
    const Stamp moment = std::clamp(stamp - durationFromSeconds(config_.bearings.latency_s),
                                    *last_fused_, std::max(*last_fused_, track_.newest()));
    if (!track_.covers(moment)) return std::nullopt;
    const AzimuthPrediction azimuth =
        tracker_->filter().predictAzimuthAfter(track_.motionTo(moment));
    return BearingPrediction{stamp, azimuth.azimuth_rad, azimuth.variance_rad2,
                             light_id_.value_or(kUnknownLight)};
  }

  void setPaused(bool paused) {
    paused_ = paused;
    if (paused) queue_.clear();
  }

  CalibrationResult result() const;

 private:
  InputOutcome countBearings(const InputOutcome& outcome) {
    ++counts_.bearing_inputs[outcome.status];
    return outcome;
  }

  void followTravel(const WheelTravel& travel) {
    if (last_travel_) {
      const double left_m = travel.left_m - last_travel_->left_m;
      const double right_m = travel.right_m - last_travel_->right_m;
      counts_.distance_travelled_m += 0.5 * std::abs(left_m + right_m);
      counts_.rotation_travelled_rad +=
          std::abs(right_m - left_m) / config_.drive.wheel_separation_m;
    }
    last_travel_ = travel;
    ++counts_.ticks_used;
    track_.add(travel);
  }

  void fuseCovered() {
    const Duration window = durationFromSeconds(config_.bearings.reorder_window_s);
    while (!queue_.empty() && !track_.empty() && queue_.oldest() + window <= track_.newest()) {
      fuse(queue_.takeOldest());
    }
  }

  void fuse(const BearingSet& bearings) {
    if (last_fused_ && bearings.stamp <= *last_fused_) {
      countBearings(
          {InputStatus::kStampNotAfterLast, secondsFromDuration(*last_fused_ - bearings.stamp)});
      return;
    }
    if (!track_.covers(bearings.stamp)) {
      countBearings(
          {InputStatus::kTicksLost, secondsFromDuration(track_.oldest() - bearings.stamp)});
      return;
    }
    const OdometryIncrement motion = track_.motionTo(bearings.stamp);
    track_.anchorAt(bearings.stamp);
    last_fused_ = bearings.stamp;
    const std::vector<Bearing> candidates = ofThisLight(bearings.candidates);
    motion_since_sight_ = append(motion_since_sight_, motion);
    if (tracker_) track(motion, candidates);
    if (!started_) start(motion, candidates);
  }

  /// Lights that a sensor tells apart are told apart here too; the first one seen is the one.
  std::vector<Bearing> ofThisLight(const std::vector<Bearing>& candidates) const {
    std::vector<Bearing> ours;
    for (const Bearing& candidate : candidates) {
      const bool other =
          light_id_ && candidate.light_id != kUnknownLight && candidate.light_id != *light_id_;
      if (!other) ours.push_back(candidate);
    }
    return ours;
  }

  /// Nothing is known yet, or only a guess that a filter works on meanwhile: collect sights until
  /// they tell mount and light by themselves, and hand over to the filter.
  void start(const OdometryIncrement& motion, const std::vector<Bearing>& candidates) {
    picker_.move(motion);
    const std::optional<Bearing> light = picker_.pick(candidates);
    if (!light) return;
    noteLight(*light);
    remember(*light);
    if (!tracker_) ++counts_.bearings_used;
    if (!attempt_) startFromGuess(*light);
    if (attempt_ && *last_fused_ < next_attempt_) return;
    next_attempt_ = *last_fused_ + kAttemptInterval;
    attempt_ = initializer_.attempt();
    if (!attempt_->ready()) return;
    tracker_.emplace(config_.filter, attempt_->estimate, attempt_->bearing_correlation);
    judge_.emplace(config_.converged, config_.initializer.batch);
    started_ = true;
  }

  void startFromGuess(const Bearing& light) {
    const StartConfig& guess = config_.start;
    if (guess.kind != StartConfig::Kind::kGuess) return;
    constexpr double kUncorrelated = 0.0;
    tracker_.emplace(
        config_.filter,
        placeLight(mountFromGuess(guess), {guess.light_distance_m, guess.light_distance_stddev_m},
                   light.azimuth_rad, light.azimuth_variance_rad2),
        kUncorrelated);
  }

  void track(const OdometryIncrement& motion, const std::vector<Bearing>& candidates) {
    tracker_->move(motion);
    const Association association = tracker_->look(candidates);
    switch (association.kind) {
      case Association::Kind::kNothingSeen:
        return;
      case Association::Kind::kGated:
      case Association::Kind::kAmbiguous:
        ++counts_.bearings_gated;
        break;
      case Association::Kind::kFound:
        ++counts_.bearings_used;
        noteLight(candidates[association.candidate]);
        if (started_) remember(candidates[association.candidate]);
        break;
    }
    if (started_) judge_->judge(*tracker_, initializer_.record().sights());
    if (!tracker_->isLost()) return;
    tracker_.reset();
    if (started_) startAnew();
  }

  /// Keeps a sight: for the initialiser before the start, for the judge after it.
  void remember(const Bearing& light) {
    initializer_.add(
        {*last_fused_, motion_since_sight_, light.azimuth_rad, light.azimuth_variance_rad2});
    motion_since_sight_ = {};
  }

  void startAnew() {
    started_ = false;
    judge_.reset();
    initializer_.restart();
    picker_.restart();
    motion_since_sight_ = {};
  }

  void noteLight(const Bearing& light) {
    if (light.light_id != kUnknownLight) light_id_ = light.light_id;
  }

  CalibratorConfig config_;
  WheelOdometer odometer_;
  OdometryTrack track_;
  BearingQueue queue_;
  LightPicker picker_;
  Initializer initializer_;
  OdometryIncrement motion_since_sight_;  ///< since the initialiser's last sight
  std::optional<StartAttempt> attempt_;   ///< the initialiser's last one
  Stamp next_attempt_;
  std::optional<MountTracker> tracker_;
  std::optional<ConvergenceJudge> judge_;  ///< of tracker_, once started
  bool started_ = false;  ///< tracker_ carries on from the initialiser, not from a guess
  std::optional<WheelTravel> last_travel_;
  std::optional<Stamp> last_fused_;  ///< on the encoders' clock
  std::optional<std::int32_t> light_id_;
  bool paused_ = false;
  CalibrationResult counts_;  ///< only what is counted up is kept here
};

CalibrationResult Calibrator::Impl::result() const {
  CalibrationResult result = counts_;
  result.stamp = last_fused_.value_or(Stamp());
  result.bearings_waiting = static_cast<std::uint32_t>(queue_.size());
  result.state =
      track_.empty() ? CalibrationState::kWaitingForTicks : CalibrationState::kWaitingForLight;
  if (attempt_) {
    result.state = isDegenerate(*attempt_) ? CalibrationState::kDegenerateMotion
                                           : CalibrationState::kInitialising;
  }
  if (tracker_) {
    result.cartesian_state = tracker_->filter().cartesian();
    result.paper_state = tracker_->filter().paper();
    result.base_from_sensor = mountFromCartesian(*result.cartesian_state);
    const Consistency consistency = tracker_->consistency();
    result.nis = consistency.nis;
    result.nis_mean = consistency.nis_mean;
  }
  if (started_) result.state = judge_->last().state;
  if (paused_) result.state = CalibrationState::kPaused;
  if (paused_ || !attempt_) {
    result.advice = adviceFor(result.state);
  } else {
    result.advice = started_ ? judge_->last().advice : adviceFor(*attempt_);
  }
  return result;
}

Calibrator::Calibrator(const CalibratorConfig& config) : impl_(std::make_unique<Impl>(config)) {}
Calibrator::~Calibrator() = default;
Calibrator::Calibrator(Calibrator&&) noexcept = default;
Calibrator& Calibrator::operator=(Calibrator&&) noexcept = default;

InputOutcome Calibrator::addTicks(const WheelCounts& ticks, Stamp received) {
  return impl_->addReading(ticks, received);
}

InputOutcome Calibrator::addAngles(const WheelAngles& angles, Stamp received) {
  return impl_->addReading(angles, received);
}

InputOutcome Calibrator::addBearings(const BearingSet& bearings, Stamp received) {
  return impl_->addBearings(bearings, received);
}

std::optional<BearingPrediction> Calibrator::predictBearing(Stamp stamp) const {
  return impl_->predictBearing(stamp);
}

CalibrationResult Calibrator::result() const { return impl_->result(); }

void Calibrator::reset() { impl_ = std::make_unique<Impl>(impl_->config()); }

void Calibrator::setPaused(bool paused) { impl_->setPaused(paused); }

}  // namespace bearing_calibration
