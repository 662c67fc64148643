#include "bearing_calibration/calibration/mount_calibration.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "bearing_calibration/calibration/driver_advice.h"
#include "bearing_calibration/calibration/fault_finder.h"
#include "bearing_calibration/calibration/light_start.h"
#include "bearing_calibration/calibration/mount_agreement.h"
#include "bearing_calibration/calibration/slip_rivals.h"
#include "bearing_calibration/common/chi_square.h"

namespace bearing_calibration {
namespace {

/// When a piece of work on the record is worth doing again: after a time, and once the record has
/// grown by a share of itself. So an endless record costs ever less.
struct Schedule {
  Duration interval;
  double growth;
};
constexpr Schedule kAttempts{std::chrono::seconds(1), 0.05};      // tens of milliseconds
constexpr Schedule kRefinements{std::chrono::seconds(1), 0.005};  // tens of milliseconds
constexpr Schedule kDiagnoses{std::chrono::seconds(20), 1.0};     // up to a second

/// A light that is passed closely, or a slip, can make one attempt fail; not so many in a row.
constexpr int kMisfitsToSay = 5;

Stamp nextTime(const Schedule& schedule, const std::vector<Sight>& record) {
  const Duration length = record.back().stamp - record.front().stamp;
  const Duration grown = durationFromSeconds(schedule.growth * secondsFromDuration(length));
  return record.back().stamp + std::max(schedule.interval, grown);
}

MountEstimate mountFromGuess(const StartConfig& guess) {
  const double position_variance = guess.position_stddev_m * guess.position_stddev_m;
  MountEstimate mount;
  mount.mean << guess.x_m, guess.y_m, guess.yaw_rad;
  mount.covariance.diagonal() << position_variance, position_variance,
      guess.yaw_stddev_rad * guess.yaw_stddev_rad;
  return mount;
}

constexpr double kNoAzimuth = std::numeric_limits<double>::quiet_NaN();

void note(Look::Kind kind, const Bearing& light, Look* look) {
  look->kind = kind;
  look->sight.azimuth_rad = light.azimuth_rad;
  look->sight.azimuth_variance_rad2 = light.azimuth_variance_rad2;
}

}  // namespace

MountCalibration::MountCalibration(const CalibratorConfig& config)
    : config_(config), initializer_(config.initializer), batch_(config.initializer.batch) {}

Look MountCalibration::look(Stamp stamp, const OdometryIncrement& motion,
                            const std::vector<Bearing>& candidates) {
  const std::vector<Bearing> ours = ofThisLight(candidates);
  motion_since_sight_ = append(motion_since_sight_, motion);
  picker_.move(motion);
  Look look;
  look.sight = {stamp, motion, kNoAzimuth, kNoAzimuth};
  if (tracker_) {
    tracker_->move(motion);
    follow(stamp, ours, &look);
  }
  if (!started_) start(stamp, ours, &look);
  return look;
}

/// Lights that a sensor tells apart are told apart here too; the first one seen is the one.
std::vector<Bearing> MountCalibration::ofThisLight(const std::vector<Bearing>& candidates) const {
  std::vector<Bearing> ours;
  for (const Bearing& candidate : candidates) {
    const bool other =
        light_id_ && candidate.light_id != kUnknownLight && candidate.light_id != *light_id_;
    if (!other) ours.push_back(candidate);
  }
  return ours;
}

/// Nothing is known yet, or only a guess that a filter works on meanwhile.
void MountCalibration::start(Stamp stamp, const std::vector<Bearing>& candidates, Look* look) {
  const std::optional<Bearing> light = picker_.pick(candidates);
  if (!light) return;
  note(Look::Kind::kTaken, *light, look);
  noteLight(*light);
  remember(stamp, *light);
  if (!tracker_) ++bearings_used_;
  if (!attempt_) startFromGuess(*light);
  if (attempt_ && stamp < next_attempt_) return;
  next_attempt_ = nextTime(kAttempts, initializer_.record().sights());
  attempt_ = initializer_.attempt();
  misfits_ = doesNotFit(*attempt_) ? misfits_ + 1 : 0;
  if (misfits_ >= kMisfitsToSay) diagnose(stamp);
  if (!attempt_->ready()) return;
  diagnosis_.clear();
  tracker_.emplace(config_.filter, withEarlier(attempt_->estimate), attempt_->bearing_correlation);
  judge_.emplace(config_.converged);
  started_ = true;
}

void MountCalibration::startFromGuess(const Bearing& light) {
  const StartConfig& guess = config_.start;
  constexpr double kUncorrelated = 0.0;
  if (earlier_) {
    constexpr LightDistance kSomewhereNear{2.0, 1.0};  // corrected by the first metre driven
    tracker_.emplace(
        config_.filter,
        placeLight(*earlier_, kSomewhereNear, light.azimuth_rad, light.azimuth_variance_rad2),
        kUncorrelated);
    return;
  }
  if (guess.kind != StartConfig::Kind::kGuess) return;
  tracker_.emplace(
      config_.filter,
      placeLight(mountFromGuess(guess), {guess.light_distance_m, guess.light_distance_stddev_m},
                 light.azimuth_rad, light.azimuth_variance_rad2),
      kUncorrelated);
}

void MountCalibration::follow(Stamp stamp, const std::vector<Bearing>& candidates, Look* look) {
  const Association association = tracker_->look(candidates);
  if (association.kind == Association::Kind::kNothingSeen) return;
  const bool found = association.kind == Association::Kind::kFound;
  note(found                                               ? Look::Kind::kTaken
       : association.kind == Association::Kind::kAmbiguous ? Look::Kind::kAmbiguous
                                                           : Look::Kind::kGated,
       candidates[association.candidate], look);
  ++(found ? bearings_used_ : bearings_gated_);
  if (found) noteLight(candidates[association.candidate]);
  if (started_) {
    remember(stamp, candidates[association.candidate]);
    refineAndJudge(stamp);
    if (judge_->last().state == CalibrationState::kInconsistent) diagnose(stamp);
  }
  if (started_ && config_.knocked.start_anew && judge_->last().knocked) return followKnock();
  if (!tracker_->isLost()) return;
  tracker_.reset();
  look->lost_light = started_;
  if (started_) startAnew();
}

/// Nothing of the old mount holds any longer.
void MountCalibration::followKnock() {
  knock_ = "the mount was knocked and is calibrated anew: ";
  earlier_.reset();
  tracker_.reset();
  attempt_.reset();
  startAnew();
}

/// The filter cannot take back what it has once believed: a slip that passed the gate, a bearing
/// that was none. The batch over the record can, and knows about them by what came after.
void MountCalibration::refineAndJudge(Stamp stamp) {
  if (stamp < next_refinement_) return;
  const std::vector<Sight>& sights = initializer_.record().sights();
  next_refinement_ = nextTime(kRefinements, sights);
  const BatchEstimate batch =
      batch_.estimate(sights, {tracker_->filter().cartesian().mean, sights.size() - 1});
  std::optional<BatchEstimate> settled;
  if (batch.converged && batch.inlierFraction() >= config_.initializer.min_inlier_fraction) {
    SlipAverage average = averageOverSlips(sights, batch, config_.initializer.batch);
    tracker_->rebase(withEarlier(average.estimate), average.best.correlation);
    settled = std::move(average.best);
  }
  judge_->judge(*tracker_, sights, settled);
}

/// An estimate from the sights, with the earlier calibration unless they contradict it: then that
/// one is forgotten.
CartesianEstimate MountCalibration::withEarlier(const CartesianEstimate& estimate) {
  constexpr double kFalseAlarm = 1e-4;
  if (earlier_ && disagreement(mountFromCartesian(estimate), *earlier_) >
                      chiSquareQuantile(1.0 - kFalseAlarm, 3.0)) {
    earlier_.reset();
  }
  return earlier_ ? withKnownMount(estimate, *earlier_) : estimate;
}

/// Which single fault of the robot would explain the record.
void MountCalibration::diagnose(Stamp stamp) {
  if (stamp < next_diagnosis_) return;
  next_diagnosis_ = nextTime(kDiagnoses, initializer_.record().sights());
  diagnosis_ = ::bearing_calibration::describe(findFault(
      initializer_.record().sights(), config_.drive.wheel_separation_m, config_.initializer));
}

/// Keeps a sight: for the initialiser before the start, for batch and judge after it.
void MountCalibration::remember(Stamp stamp, const Bearing& light) {
  initializer_.add({stamp, motion_since_sight_, light.azimuth_rad, light.azimuth_variance_rad2});
  motion_since_sight_ = {};
}

void MountCalibration::noteLight(const Bearing& light) {
  if (light.light_id != kUnknownLight) light_id_ = light.light_id;
}

void MountCalibration::startAnew() {
  started_ = false;
  judge_.reset();
  initializer_.restart();
  picker_.restart();
  motion_since_sight_ = {};
}

std::optional<AzimuthPrediction> MountCalibration::predictAzimuthAfter(
    const OdometryIncrement& motion) const {
  if (!tracker_) return std::nullopt;
  return tracker_->filter().predictAzimuthAfter(motion);
}

void MountCalibration::describe(CalibrationResult* result) const {
  result->bearings_used = bearings_used_;
  result->bearings_gated = bearings_gated_;
  if (!tracker_ && attempt_ && attempt_->obstacle == StartObstacle::kWeakDirection) {
    // right, but not yet narrow enough for a linearised filter to carry on from
    result->cartesian_state = attempt_->estimate;
    result->paper_state = paperFromCartesian(attempt_->estimate);
    result->base_from_sensor = mountFromCartesian(attempt_->estimate);
  }
  if (tracker_) {
    result->cartesian_state = tracker_->filter().cartesian();
    result->paper_state = tracker_->filter().paper();
    result->base_from_sensor = mountFromCartesian(*result->cartesian_state);
    const Consistency consistency = tracker_->consistency();
    result->nis = consistency.nis;
    result->nis_mean = consistency.nis_mean;
  }
  if (started_) {
    result->state = judge_->last().state;
    result->advice = judge_->last().advice;
  } else if (attempt_) {
    result->state = misfits_ >= kMisfitsToSay ? CalibrationState::kInconsistent
                    : isDegenerate(*attempt_) ? CalibrationState::kDegenerateMotion
                                              : CalibrationState::kInitialising;
    result->advice = adviceFor(*attempt_);
  }
  if (result->state == CalibrationState::kInconsistent && !diagnosis_.empty()) {
    result->advice = diagnosis_;
  }
  const bool calibrated = result->state == CalibrationState::kConverged;
  if (!knock_.empty() && !calibrated) {
    result->advice = knock_ + (result->advice.empty() ? adviceFor(result->state) : result->advice);
  }
}

}  // namespace bearing_calibration
