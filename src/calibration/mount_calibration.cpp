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

constexpr Pace kAttempts{std::chrono::seconds(1), 0.05};  // tens of milliseconds
/// On a record that nothing explains, which takes longest.
constexpr Pace kAttemptsInVain{std::chrono::seconds(2), 0.1};
constexpr Pace kDiagnoses{std::chrono::seconds(20), 1.0};  // up to a second
constexpr std::chrono::seconds kFitInterval{1};            // tens of milliseconds

/// A light that is passed closely, or a slip, can make one attempt fail; not so many in a row.
constexpr int kMisfitsToSay = 5;

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
  look->sight.elevation = elevationOf(light);
}

}  // namespace

MountCalibration::MountCalibration(const CalibratorConfig& config, FitsRun fits_run)
    : config_(config),
      fits_run_(fits_run),
      initializer_(config.initializer),
      batch_(config.initializer.batch) {}

Look MountCalibration::look(const BearingSet& image, const OdometryIncrement& motion,
                            const TravelNearby& nearby) {
  is_work_due_ = false;
  const BearingSet ours{image.stamp, ofThisLight(image.candidates)};
  motion_since_sight_ = append(motion_since_sight_, motion);
  picker_.move(motion);
  Look look;
  look.sight = {image.stamp, motion, kNoAzimuth, kNoAzimuth, nearby};
  if (weak_) weak_->move(motion);
  if (tracker_) {
    tracker_->move(withNoise(motion, noise_));
    follow(ours, nearby, &look);
  }
  if (!started_) start(ours, nearby, &look);
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
void MountCalibration::start(const BearingSet& image, const TravelNearby& nearby, Look* look) {
  const Stamp stamp = image.stamp;
  const std::optional<Bearing> light = picker_.pick(image.candidates);
  if (!light) return;
  note(Look::Kind::kTaken, *light, look);
  noteLight(*light);
  remember(stamp, *light, nearby);
  if (!tracker_) ++bearings_used_;
  if (!attempt_ && !tracker_) startFromGuess(*light);
  is_work_due_ = !attempt_ || attempts_.isDue(initializer_.record());
  if (is_work_due_ && fits_run_ == FitsRun::kAtOnce) work();
}

void MountCalibration::work() {
  is_work_due_ = false;
  if (!started_) return attemptStart();
  if (isFitDue()) refineAndJudge();
  if (judge_->last().state == CalibrationState::kInconsistent) diagnose();
  if (config_.knocked.start_anew && judge_->last().knocked) followKnock();
}

void MountCalibration::attemptStart() {
  attempt_ = initializer_.attempt();
  moveAlong(*attempt_);
  misfits_ = doesNotFit(*attempt_) ? misfits_ + 1 : 0;
  const bool in_vain = misfits_ >= kMisfitsToSay;
  attempts_.begin(initializer_.record(), in_vain ? kAttemptsInVain : kAttempts);
  if (in_vain) diagnose();
  if (!attempt_->ready()) return;
  diagnosis_.clear();
  noise_ = attempt_->noise;
  noteSettled(
      {attempt_->estimate.mean, initializer_.record().sights().size() - 1, attempt_->errors.mean});
  startTracker(withEarlier({attempt_->estimate, attempt_->errors}), attempt_->bearing_correlation);
  judge_.emplace(config_.converged);
  started_ = true;
}

void MountCalibration::startFromGuess(const Bearing& light) {
  const StartConfig& guess = config_.start;
  constexpr double kUncorrelated = 0.0;
  RobotEstimate robot;
  robot.errors = priorEstimate(config_.initializer.batch.errors);
  if (earlier_) {
    constexpr LightDistance kSomewhereNear{2.0, 1.0};  // corrected by the first metre driven
    robot.cartesian = placeLight(earlier_->mount(), kSomewhereNear, light.azimuth_rad,
                                 light.azimuth_variance_rad2);
    startTracker(robot, kUncorrelated);
    return;
  }
  if (guess.kind != StartConfig::Kind::kGuess) return;
  robot.cartesian =
      placeLight(mountFromGuess(guess), {guess.light_distance_m, guess.light_distance_stddev_m},
                 light.azimuth_rad, light.azimuth_variance_rad2);
  startTracker(robot, kUncorrelated);
}

void MountCalibration::startTracker(const RobotEstimate& estimate, double bearing_correlation) {
  tracker_.emplace(config_.filter, estimate, bearing_correlation,
                   errorsInUse(config_.initializer.batch.errors));
}

void MountCalibration::moveAlong(const StartAttempt& attempt) {
  weak_.reset();
  if (attempt.obstacle != StartObstacle::kWeakDirection) return;
  FilterConfig filter = config_.filter;
  filter.chart = FilterConfig::Chart::kCartesian;  // in which a motion is linear
  weak_.emplace(filter, RobotEstimate{attempt.estimate, attempt.errors},
                attempt.bearing_correlation, errorsInUse(config_.initializer.batch.errors));
}

void MountCalibration::follow(const BearingSet& image, const TravelNearby& nearby, Look* look) {
  const Stamp stamp = image.stamp;
  const std::vector<Bearing>& candidates = image.candidates;
  const Association association = looksForNoise()
                                      ? tracker_->look(withNoise(candidates, noise_), nearby)
                                      : tracker_->look(candidates, nearby);
  if (association.kind == Association::Kind::kNothingSeen) return;
  const bool found = association.kind == Association::Kind::kFound;
  note(found                                               ? Look::Kind::kTaken
       : association.kind == Association::Kind::kAmbiguous ? Look::Kind::kAmbiguous
                                                           : Look::Kind::kGated,
       candidates[association.candidate], look);
  ++(found ? bearings_used_ : bearings_gated_);
  if (found) noteLight(candidates[association.candidate]);
  if (started_) {
    remember(stamp, candidates[association.candidate], nearby);
    is_work_due_ = isFitDue() || (judge_->last().state == CalibrationState::kInconsistent &&
                                  diagnoses_.isDue(initializer_.record()));
    if (is_work_due_ && fits_run_ == FitsRun::kAtOnce) work();
    if (!started_) return;  // after a knock
  }
  if (!tracker_->isLost() || tracker_->isSearching()) return;
  look->lost_light = started_;
  tracker_.reset();
  if (started_) startAnew();
}

/// Nothing of the old mount holds any longer.
void MountCalibration::followKnock() {
  knock_ = "the mount was knocked and is calibrated anew: ";
  earlier_.reset();
  startAnew();
}

/// The batch over the record, from where it settled the last time: since then the filter may have
/// followed something else. Only without success there, from the filter.
BatchEstimate MountCalibration::fitRecord(const std::vector<Sight>& sights,
                                          const RobotEstimate& running) const {
  if (settled_) {
    const auto there = std::find_if(sights.begin(), sights.end(), [this](const Sight& sight) {
      return sight.stamp == settled_->stamp;
    });
    if (there != sights.end()) {  // it has not been thinned out
      RecordStart start = settled_->start;
      start.sight = static_cast<std::size_t>(there - sights.begin());
      BatchEstimate batch = batch_.estimate(sights, start);
      if (hasSettled(batch)) return batch;
    }
  }
  return batch_.estimate(sights, {running.cartesian.mean, sights.size() - 1, running.errors.mean});
}

void MountCalibration::noteSettled(const RecordStart& start) {
  settled_ = {initializer_.record().sights()[start.sight].stamp, start};
}

void MountCalibration::noteAnswer(const SlipAverage& settled) {
  const std::vector<Sight>& sights = initializer_.record().sights();
  const bool tells_one = !settled.is_disputed && tellsOneMount(*tracker_, sights, settled.best);
  answer_ = OwnAnswer{{}, settled.best, settled.estimate, tells_one, motionOf(sights), noise_};
  for (const Sight& sight : sights) answer_->stamps.push_back(sight.stamp);
}

bool MountCalibration::hasSettled(const BatchEstimate& batch) const {
  return batch.converged && batch.inlierFraction() >= config_.initializer.min_inlier_fraction;
}

bool MountCalibration::isFitDue() const {
  const SightRecord& record = initializer_.record();
  return fits_.isDue(record) || (fits_.isTime(record) && ConvergenceJudge::isDoubted(*tracker_));
}

/// The filter cannot take back what it has once believed: a slip that passed the gate, a bearing
/// that was none. The batch over the record can, and knows about them by what came after.
void MountCalibration::refineAndJudge() {
  const SightRecord& record = initializer_.record();
  fits_.begin(record, {kFitInterval, config_.refit_growth});
  const std::vector<Sight>& stated = record.sights();
  const std::vector<Sight> scaled =
      looksForNoise() ? withNoise(stated, noise_) : std::vector<Sight>();
  const std::vector<Sight>& sights = looksForNoise() ? scaled : stated;
  const RobotEstimate robot = tracker_->filter().robot();
  const BatchEstimate batch = fitRecord(sights, robot);
  std::optional<SlipAverage> settled;
  if (hasSettled(batch)) {
    SlipAverage average = averageOverSlips(sights, batch, config_.initializer.batch);
    if (!tracker_->isSearching()) {
      tracker_->rebase(withEarlier(average.estimate), average.best.correlation);
    }
    noteSettled(surestStart(average.best));
    if (config_.lights.most > 1) noteAnswer(average);
    noteNoise(average.best);
    settled = std::move(average);
  }
  judge_->judge(*tracker_, sights, settled);
}

/// For the next fit: all hypotheses of one must be weighed alike.
void MountCalibration::noteNoise(const BatchEstimate& fit) {
  const std::vector<Sight>& sights = initializer_.record().sights();
  correlation_time_ = correlationTime(sights, fit.correlation);
  const InitializerConfig& config = config_.initializer;
  if (looksForNoise()) {
    noise_ = findNoiseLevels(sights, fit, config.batch.errors, config.noise);
  }
}

/// An estimate from the sights, with the earlier calibration unless they contradict it: then that
/// one is forgotten.
RobotEstimate MountCalibration::withEarlier(const RobotEstimate& estimate) {
  constexpr double kFalseAlarm = 1e-4;
  if (earlier_ && disagreement(mountFromCartesian(estimate.cartesian), earlier_->mount()) >
                      chiSquareQuantile(1.0 - kFalseAlarm, 3.0)) {
    earlier_.reset();
  }
  if (!earlier_) return estimate;
  return ::bearing_calibration::withEarlier(estimate, *earlier_, config_.initializer.batch.errors);
}

/// Which single fault of the robot would explain the record.
void MountCalibration::diagnose() {
  if (!diagnoses_.isDue(initializer_.record())) return;
  diagnoses_.begin(initializer_.record(), kDiagnoses);
  diagnosis_ = ::bearing_calibration::describe(findFault(
      initializer_.record().sights(), config_.drive.wheel_separation_m, config_.initializer));
}

/// Keeps a sight: for the initialiser before the start, for batch and judge after it.
void MountCalibration::remember(Stamp stamp, const Bearing& light, const TravelNearby& nearby) {
  initializer_.add({stamp, motion_since_sight_, light.azimuth_rad, light.azimuth_variance_rad2,
                    nearby, elevationOf(light)});
  motion_since_sight_ = {};
}

void MountCalibration::noteLight(const Bearing& light) {
  if (light.light_id != kUnknownLight) light_id_ = light.light_id;
}

/// Forgets what the sights have said, but not which light it is, nor what is said about it all.
void MountCalibration::startAnew() {
  MountCalibration fresh(config_, fits_run_);
  fresh.earlier_ = earlier_;
  fresh.knock_ = knock_;
  fresh.light_id_ = light_id_;
  fresh.bearings_used_ = bearings_used_;
  fresh.bearings_gated_ = bearings_gated_;
  *this = std::move(fresh);
}

std::optional<AzimuthPrediction> MountCalibration::predictAzimuthAfter(
    const OdometryIncrement& motion, const TravelNearby& nearby) const {
  if (!tracker_ || tracker_->isSearching()) return std::nullopt;
  return tracker_->filter().predictAzimuthAfter(motion, nearby);
}

void MountCalibration::describe(CalibrationResult* result) const {
  result->error_priors = config_.initializer.batch.errors;
  result->robot_errors = priorEstimate(config_.initializer.batch.errors);
  result->noise_priors = config_.initializer.noise;
  result->noise = noise_;
  result->correlation_time = correlation_time_;
  result->bearings_used = bearings_used_;
  result->bearings_gated = bearings_gated_;
  if (const std::optional<MountTracker>& known = tracker_ ? tracker_ : weak_; known) {
    const RobotEstimate robot = known->filter().robot();
    result->cartesian_state = robot.cartesian;
    result->robot_errors = robot.errors;
    result->paper_state = known->filter().paper();
    result->base_from_sensor = mountFromCartesian(*result->cartesian_state);
    const Consistency consistency = known->consistency();
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
  result->lights = {{lightId(), result->state, result->cartesian_state, true, bearings_used_, ""}};
  if (result->state == CalibrationState::kInconsistent && !diagnosis_.empty()) {
    result->advice = diagnosis_;
  }
  const bool calibrated = result->state == CalibrationState::kConverged;
  if (!knock_.empty() && !calibrated) {
    result->advice = knock_ + (result->advice.empty() ? adviceFor(result->state) : result->advice);
  }
}

}  // namespace bearing_calibration
