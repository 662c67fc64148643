#include "bearing_calibration/calibration/calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/calibration/fits_beside.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/input/bearing_input.h"
#include "bearing_calibration/input/bearing_queue.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"

namespace bearing_calibration::core {

/// The doors: checks and counts what comes in, brings both streams into one order of time, and
/// hands each image with the motion before it to the calibration.
class Calibrator::Impl {
 public:
  Impl(const CalibratorConfig& config, std::unique_ptr<FitsBeside> calibration)
      : config_(config),
        pairing_(config.drive.counter_bits, config.wheel_times.max_apart_s),
        odometer_(config.drive),
        track_(config.drive.wheel_separation_m, config.wheel_noise,
               durationFromSeconds(config.wheel_times.history_s)),
        queue_(static_cast<std::size_t>(config.bearings.max_waiting)),
        calibration_(std::move(calibration)) {}

  const CalibratorConfig& config() const { return config_; }

  template <class Reading>
  InputOutcome addReading(const Reading& reading, Stamp received) {
    InputOutcome outcome = checkStamp(reading.stamp, received, config_.bearings.max_future_s);
    if (outcome.accepted()) outcome = odometer_.add(reading);
    ++counts_.tick_inputs[outcome.status];
    noteStepBack();
    if (odometer_.travel() && (track_.empty() || odometer_.travel()->stamp > track_.newest())) {
      followTravel(*odometer_.travel());
      fuseCovered();
    }
    return outcome;
  }

  InputOutcome addWheel(WheelSide side, const WheelCount& count, Stamp received) {
    const InputOutcome stamp = checkStamp(count.stamp, received, config_.bearings.max_future_s);
    if (!stamp.accepted()) {
      ++counts_.tick_inputs[stamp.status];
      return stamp;
    }
    const PairingOutcome paired = pairing_.add(side, count);
    InputOutcome worst;
    for (const InputOutcome& refused : paired.refused) {
      ++counts_.tick_inputs[refused.status];
      if (refused.status == InputStatus::kStampNotAfterLast) noteLate(side, count.stamp);
      if (!worst.isBadInput()) worst = refused;
    }
    for (const WheelCounts& counts : paired.pairs) {
      const InputOutcome outcome = addReading(counts, received);
      if (!worst.isBadInput()) worst = outcome;
    }
    return worst;
  }

  InputOutcome addBearings(const BearingSet& bearings, Stamp received) {
    const InputOutcome stamp = checkStamp(bearings.stamp, received, config_.bearings.max_future_s);
    if (!stamp.accepted()) return countBearings(stamp);
    if (paused_) return countBearings({InputStatus::kIgnoredPaused, 0.0});
    const InputOutcome geometry = judgeGeometry(bearings.geometry);
    if (!geometry.accepted()) return countBearings(geometry);
    CheckedBearings checked = checkBearings(bearings, config_.bearings);
    const std::optional<Stamp> last = std::max(last_fused_, passed_twice_);
    if (last && checked.bearings.stamp <= *last) {
      return countBearings(
          {InputStatus::kStampNotAfterLast, secondsFromDuration(*last - checked.bearings.stamp)});
    }
    InputOutcome worst;
    if (isLessKnown(bearings.geometry)) checked.remarks.push_back(assume(bearings.geometry));
    for (const InputOutcome& remark : checked.remarks) {
      countBearings(remark);
      if (!worst.isBadInput()) worst = remark;
    }
    if (!queue_.add(std::move(checked.bearings))) {
      countBearings({InputStatus::kQueueFull, static_cast<double>(config_.bearings.max_waiting)});
    }
    fuseCovered();
    if (!worst.isBadInput()) countBearings({});
    return worst;
  }

  std::optional<BearingPrediction> predictBearing(Stamp stamp) const {
    if (!last_fused_) return std::nullopt;
    const Stamp moment = std::clamp(stamp - durationFromSeconds(config_.bearings.latency_s),
                                    *last_fused_, std::max(*last_fused_, track_.newest()));
    if (!track_.covers(moment)) return std::nullopt;
    const auto azimuth = calibration_->live().predictAzimuthAfter(track_.motionTo(moment),
                                                                  track_.travelAround(moment));
    if (!azimuth) return std::nullopt;
    return BearingPrediction{stamp, azimuth->azimuth_rad, azimuth->variance_rad2,
                             calibration_->live().lightId()};
  }

  std::optional<BasePlace> place() const {
    if (track_.empty()) return std::nullopt;
    const Stamp newest = track_.newest();
    return BasePlace{newest, start_from_fused_ * track_.motionTo(newest).start_from_end};
  }

  void resume(const LastingEstimate& earlier) {
    earlier_ = earlier;
    calibration_->resume(earlier);
  }

  void takeOverFit() {
    calibration_->takeOver();
    calibration_->rethrow();
  }
  FitsReport fits() const { return calibration_->report(); }
  /// With all forgotten; nothing else may be called afterwards.
  std::unique_ptr<FitsBeside> release() {
    calibration_->forget(config_);
    return std::move(calibration_);
  }

  void observe(OutcomeObserver observer) { observer_ = std::move(observer); }
  const OutcomeObserver& observer() const { return observer_; }

  void setPaused(bool paused) {
    paused_ = paused;
    if (!paused) return;
    queue_.clear();
    calibration_->drop();
  }

  CalibrationResult result() const {
    CalibrationResult result = counts_;
    result.stamp = last_fused_.value_or(Stamp());
    result.start_from_base = start_from_fused_;
    result.bearings_waiting = static_cast<std::uint32_t>(queue_.size());
    result.state =
        track_.empty() ? CalibrationState::kWaitingForTicks : CalibrationState::kWaitingForLight;
    calibration_->live().describe(&result);
    if (paused_) {
      result.state = CalibrationState::kPaused;
      result.cause = Fault::kNone;
    }
    if (paused_ || result.advice.empty()) result.advice = adviceFor(result.state);
    result.advice = adviceWithSensor(counts_.bearing_inputs, result.bearings_used, result.advice);
    return result;
  }

 private:
  InputOutcome judgeGeometry(const SensorGeometry& stated) const {
    const bool has_errors =
        config_.filter.parametrisation == FilterConfig::Parametrisation::kCartesian;
    if (!has_errors && stated.harmonic_stddev_rad > 0.0) {
      return {InputStatus::kGeometryUnmodelled, stated.harmonic_stddev_rad};
    }
    return checkGeometry(stated);
  }

  /// Whether a sensor knows its geometry less well than is assumed.
  bool isLessKnown(const SensorGeometry& stated) const {
    constexpr double kSame = 1.001;
    const SensorGeometry assumed = config_.initializer.batch.errors.geometry();
    return stated.harmonic_stddev_rad > kSame * assumed.harmonic_stddev_rad ||
           stated.nearness_stddev_rad_m > kSame * assumed.nearness_stddev_rad_m;
  }

  /// Begins again with a sensor of this geometry: nothing that was made of its bearings holds.
  InputOutcome assume(const SensorGeometry& stated) {
    config_.initializer.batch.errors.setGeometry(stated);
    calibration_->forget(config_);
    if (earlier_) calibration_->resume(*earlier_);
    if (!last_fused_) return {};
    return {InputStatus::kGeometryChanged, stated.harmonic_stddev_rad};
  }

  /// The left readings give the pairs their stamps.
  void noteLate(WheelSide side, Stamp stamp) {
    if (side == WheelSide::kLeft) odometer_.noteLate(stamp);
    noteStepBack();
  }

  void noteStepBack() {
    if (!odometer_.isSteppedBack()) return;
    passed_twice_ = track_.newest();
    calibration_->drop();
  }

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
    const OdometryWindow nearby = track_.travelAround(bearings.stamp);
    track_.anchorAt(bearings.stamp);
    last_fused_ = bearings.stamp;
    start_from_fused_ = start_from_fused_ * motion.start_from_end;
    const AssociationOutcome outcome = calibration_->process(bearings, motion, nearby);
    if (observer_) observer_(outcome);
  }

  CalibratorConfig config_;
  WheelPairing pairing_;
  WheelOdometer odometer_;
  OdometryTrack track_;
  BearingQueue queue_;
  std::unique_ptr<FitsBeside> calibration_;
  std::optional<LastingEstimate> earlier_;
  std::optional<WheelTravel> last_travel_;
  std::optional<Stamp> last_fused_;  ///< on the encoders' clock
  /// The encoders' clock has stepped back from here: what is stamped earlier may be of either time.
  std::optional<Stamp> passed_twice_;
  Pose2 start_from_fused_;  ///< the base at that moment, in its frame at the first one
  bool paused_ = false;
  OutcomeObserver observer_;  ///< may be empty
  CalibrationResult counts_;  ///< only what is counted up here
};

Calibrator::Calibrator(const CalibratorConfig& config, FitsRun fits_run)
    : impl_(std::make_unique<Impl>(config,
                                   std::make_unique<FitsBeside>(validated(config), fits_run))) {}
Calibrator::~Calibrator() = default;
Calibrator::Calibrator(Calibrator&&) noexcept = default;
Calibrator& Calibrator::operator=(Calibrator&&) noexcept = default;

InputOutcome Calibrator::addTicks(const WheelCounts& ticks, Stamp received) {
  const InputOutcome outcome = impl_->addReading(ticks, received);
  impl_->takeOverFit();
  return outcome;
}

InputOutcome Calibrator::addAngles(const WheelAngles& angles, Stamp received) {
  const InputOutcome outcome = impl_->addReading(angles, received);
  impl_->takeOverFit();
  return outcome;
}

InputOutcome Calibrator::addWheel(WheelSide side, const WheelCount& count, Stamp received) {
  const InputOutcome outcome = impl_->addWheel(side, count, received);
  impl_->takeOverFit();
  return outcome;
}

InputOutcome Calibrator::addBearings(const BearingSet& bearings, Stamp received) {
  const InputOutcome outcome = impl_->addBearings(bearings, received);
  impl_->takeOverFit();
  return outcome;
}

std::optional<BearingPrediction> Calibrator::predictBearing(Stamp stamp) const {
  return impl_->predictBearing(stamp);
}

CalibrationResult Calibrator::result() const { return impl_->result(); }

void Calibrator::takeOverFit() { impl_->takeOverFit(); }

FitsReport Calibrator::fits() const { return impl_->fits(); }

std::optional<BasePlace> Calibrator::place() const { return impl_->place(); }

void Calibrator::resume(const LastingEstimate& earlier) { impl_->resume(earlier); }

void Calibrator::observe(OutcomeObserver observer) { impl_->observe(std::move(observer)); }

void Calibrator::reset() {
  OutcomeObserver observer = impl_->observer();
  impl_ = std::make_unique<Impl>(CalibratorConfig(impl_->config()), impl_->release());
  impl_->observe(std::move(observer));
}

void Calibrator::setPaused(bool paused) { impl_->setPaused(paused); }

}  // namespace bearing_calibration::core
