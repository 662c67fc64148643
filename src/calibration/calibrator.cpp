#include "bearing_calibration/calibration/calibrator.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/input/bearing_input.h"

namespace bearing_calibration::core {

Calibrator::Calibrator(const CalibratorConfig& config, FitsRun fits_run)
    : Calibrator(config, std::make_unique<FitsBeside>(validated(config), fits_run)) {}

Calibrator::Calibrator(const CalibratorConfig& config, std::unique_ptr<FitsBeside> estimation)
    : config_(config),
      assumed_(config.initializer.batch.errors.geometry()),
      pairing_(config.drive.counter_bits, config.wheel_times.max_apart_s),
      odometer_(config.drive),
      track_(config.drive.wheel_separation_m, config.wheel_noise,
             durationFromSeconds(config.wheel_times.history_s)),
      estimation_(std::move(estimation)) {}

template <class Reading>
InputOutcome Calibrator::addReading(const Reading& reading, Stamp received) {
  InputOutcome outcome = checkStamp(reading.stamp, received, config_.bearings.max_future_s);
  if (outcome.accepted()) outcome = odometer_.add(reading);
  ++counts_.tick_inputs[outcome.status];
  noteStepBack();
  if (odometer_.travel() && (track_.empty() || odometer_.travel()->stamp > track_.newest())) {
    followTravel(*odometer_.travel());
    processCovered(config_.bearings.reorder_window_s);
  }
  return outcome;
}

InputOutcome Calibrator::addTicks(const WheelCounts& ticks, Stamp received) {
  return afterwards(addReading(ticks, received));
}

InputOutcome Calibrator::addAngles(const WheelAngles& angles, Stamp received) {
  return afterwards(addReading(angles, received));
}

InputOutcome Calibrator::addOdometry(const OdometryPose& odometry, Stamp received) {
  return afterwards(addReading(odometry, received));
}

InputOutcome Calibrator::addWheel(WheelSide side, const WheelCount& count, Stamp received) {
  return afterwards(pair(side, count, received));
}

InputOutcome Calibrator::addBearings(const BearingSet& bearings, Stamp received) {
  const InputOutcome outcome = accept(bearings, received);
  processCovered(config_.bearings.reorder_window_s);
  return afterwards(outcome);
}

void Calibrator::finish() {
  processCovered(0.0);
  takeOverFit();
}

InputOutcome Calibrator::pair(WheelSide side, const WheelCount& count, Stamp received) {
  const InputOutcome stamp = checkStamp(count.stamp, received, config_.bearings.max_future_s);
  if (!stamp.accepted()) {
    ++counts_.tick_inputs[stamp.status];
    return stamp;
  }
  const PairingOutcome paired = pairing_.add(side, count);
  InputOutcome worst;
  for (const InputOutcome& refused : paired.refused) {
    ++counts_.tick_inputs[refused.status];
    if (refused.status == InputStatus::kStampNotAfterLast) {
      if (side == WheelSide::kLeft) odometer_.noteLate(count.stamp);  // it gives a pair its stamp
      noteStepBack();
    }
    if (!worst.isBadInput()) worst = refused;
  }
  for (const WheelCounts& counts : paired.pairs) {
    const InputOutcome outcome = addReading(counts, received);
    if (!worst.isBadInput()) worst = outcome;
  }
  return worst;
}

InputOutcome Calibrator::accept(const BearingSet& bearings, Stamp received) {
  const InputOutcome stamp = checkStamp(bearings.stamp, received, config_.bearings.max_future_s);
  if (!stamp.accepted()) return countBearings(stamp);
  if (paused_) return countBearings({InputStatus::kIgnoredPaused, 0.0});
  const InputOutcome geometry = judgeGeometry(bearings.geometry);
  if (!geometry.accepted()) return countBearings(geometry);
  const InputOutcome view = checkView(bearings.view);
  if (!view.accepted()) return countBearings(view);
  CheckedBearings checked = checkBearings(bearings, config_.bearings);
  const std::optional<Stamp> last = std::max(last_fused_, passed_twice_);
  if (last && checked.bearings.stamp <= *last) {
    return countBearings(
        {InputStatus::kStampNotAfterLast, secondsFromDuration(*last - checked.bearings.stamp)});
  }
  InputOutcome worst;
  if (isAnother(bearings.geometry)) {
    const InputOutcome changed = assume(bearings.geometry);
    if (changed.isWorthAWord()) checked.remarks.push_back(changed);
  }
  for (const InputOutcome& remark : checked.remarks) {
    countBearings(remark);
    if (!worst.isBadInput()) worst = remark;
  }
  waiting_.emplace(checked.bearings.stamp, std::move(checked.bearings));
  if (waiting_.size() > static_cast<std::size_t>(config_.bearings.max_waiting)) {
    waiting_.erase(waiting_.begin());
    countBearings({InputStatus::kQueueFull, static_cast<double>(config_.bearings.max_waiting)});
  }
  if (!worst.isBadInput()) countBearings({});
  return worst;
}

std::optional<BearingPrediction> Calibrator::predictBearing(Stamp stamp) const {
  if (!last_fused_) return std::nullopt;
  const Stamp moment = std::clamp(stamp - durationFromSeconds(config_.bearings.latency_s),
                                  *last_fused_, std::max(*last_fused_, track_.newest()));
  if (!track_.covers(moment)) return std::nullopt;
  const auto azimuth =
      estimation_->live().predictAzimuthAfter(track_.motionTo(moment), track_.travelAround(moment));
  if (!azimuth) return std::nullopt;
  return BearingPrediction{stamp,
                           azimuth->azimuth_rad,
                           azimuth->variance_rad2,
                           estimation_->live().lightId(),
                           azimuth->range_m,
                           azimuth->range_variance_m2};
}

std::optional<BasePlace> Calibrator::place() const {
  if (track_.empty()) return std::nullopt;
  const Stamp newest = track_.newest();
  return BasePlace{newest, start_from_fused_ * track_.motionTo(newest).start_from_end};
}

void Calibrator::resume(const StateEstimate& earlier) {
  earlier_ = earlier;
  estimation_->resume(earlier);
}

void Calibrator::takeOverFit() {
  estimation_->takeOver();
  estimation_->rethrow();
}

void Calibrator::setPaused(bool paused) {
  paused_ = paused;
  if (!paused) return;
  waiting_.clear();
  estimation_->drop();
}

CalibrationResult Calibrator::result() const {
  CalibrationResult result = counts_;
  result.stamp = last_fused_.value_or(Stamp());
  result.start_from_base = start_from_fused_;
  result.bearings_waiting = static_cast<std::uint32_t>(waiting_.size());
  result.state =
      track_.empty() ? CalibrationState::kWaitingForTicks : CalibrationState::kWaitingForLight;
  estimation_->live().describe(&result);
  if (paused_) {
    result.state = CalibrationState::kPaused;
    result.cause = Fault::kNone;
  }
  if (paused_ || result.advice.empty()) result.advice = adviceFor(result.state);
  if (result.state == CalibrationState::kInitialising ||
      result.state == CalibrationState::kDegenerateMotion ||
      result.state == CalibrationState::kConverging) {
    result.advice = in_view_.adviceWith(result.advice);
  }
  result.advice = adviceWithSensor(counts_.bearing_inputs, result.bearings_used, result.advice);
  return result;
}

void Calibrator::reset() {
  OutcomeObserver observer = std::move(observer_);
  const bool paused = paused_;
  estimation_->forget(config_);
  *this = Calibrator(CalibratorConfig(config_), std::move(estimation_));
  observe(std::move(observer));
  setPaused(paused);
}

InputOutcome Calibrator::judgeGeometry(const SensorGeometry& stated) const {
  const bool has_errors =
      config_.filter.parametrisation == FilterConfig::Parametrisation::kCartesian;
  if (!has_errors && stated.harmonic_stddev_rad > 0.0) {
    return {InputStatus::kGeometryUnmodelled, stated.harmonic_stddev_rad};
  }
  return checkGeometry(stated);
}

/// Less is known than before, or a near light's harmonic differs by more than that leaves open.
bool Calibrator::isAnother(const SensorGeometry& stated) const {
  constexpr double kSame = 1.001;
  const double nearness_rad_m =
      stated.harmonic_stddev_rad * std::abs(stated.near_per_far_m - assumed_.near_per_far_m);
  return stated.harmonic_stddev_rad > kSame * assumed_.harmonic_stddev_rad ||
         stated.nearness_stddev_rad_m > kSame * assumed_.nearness_stddev_rad_m ||
         nearness_rad_m > assumed_.nearness_stddev_rad_m;
}

InputOutcome Calibrator::assume(const SensorGeometry& stated) {
  CalibratorConfig config = config_;
  config.initializer.batch.errors.setGeometry(stated);
  assumed_ = config.initializer.batch.errors.geometry();
  estimation_->forget(config);
  if (earlier_) estimation_->resume(*earlier_);
  if (!last_fused_) return {};
  return {InputStatus::kGeometryChanged, stated.harmonic_stddev_rad};
}

void Calibrator::noteStepBack() {
  if (!odometer_.isSteppedBack()) return;
  passed_twice_ = track_.newest();
  estimation_->drop();
}

InputOutcome Calibrator::countBearings(const InputOutcome& outcome) {
  ++counts_.bearing_inputs[outcome.status];
  return outcome;
}

void Calibrator::followTravel(const WheelTravel& travel) {
  if (last_travel_) {
    const double left_m = travel.left_m - last_travel_->left_m;
    const double right_m = travel.right_m - last_travel_->right_m;
    counts_.distance_travelled_m += 0.5 * std::abs(left_m + right_m);
    counts_.rotation_travelled_rad += std::abs(right_m - left_m) / config_.drive.wheel_separation_m;
  }
  last_travel_ = travel;
  ++counts_.ticks_used;
  track_.add(travel);
}

/// The oldest image that waits, once the ticks cover it and no older one is to be expected.
std::optional<Frame> Calibrator::nextCovered(double reorder_window_s) {
  const Duration window = durationFromSeconds(reorder_window_s);
  while (!waiting_.empty() && !track_.empty() &&
         waiting_.begin()->first + window <= track_.newest()) {
    BearingSet image = waiting_.extract(waiting_.begin()).mapped();
    const Stamp stamp = image.stamp;
    if (last_fused_ && stamp <= *last_fused_) {
      countBearings({InputStatus::kStampNotAfterLast, secondsFromDuration(*last_fused_ - stamp)});
    } else if (!track_.covers(stamp)) {
      countBearings({InputStatus::kTicksLost, secondsFromDuration(track_.oldest() - stamp)});
    } else {
      Frame frame{std::move(image), track_.motionTo(stamp), track_.travelAround(stamp)};
      track_.anchorAt(stamp);
      last_fused_ = stamp;
      start_from_fused_ = start_from_fused_ * frame.motion.start_from_end;
      return frame;
    }
  }
  return std::nullopt;
}

void Calibrator::processCovered(double reorder_window_s) {
  while (const std::optional<Frame> frame = nextCovered(reorder_window_s)) {
    const AssociationOutcome outcome = estimation_->process(*frame);
    const Stamp stamp = frame->image.stamp;
    in_view_.add(frame->image.view, stamp, estimation_->live().isAnySeenAt(stamp));
    if (observer_) observer_(outcome);
  }
}

}  // namespace bearing_calibration::core
