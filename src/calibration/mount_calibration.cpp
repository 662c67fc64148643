#include "bearing_calibration/calibration/mount_calibration.h"

#include <algorithm>
#include <utility>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/judge/fault_finder.h"
#include "bearing_calibration/solve/metric_scale.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

constexpr Pace kDiagnoses{std::chrono::seconds(20), 1.0};  // up to a second

}  // namespace

MountCalibration::MountCalibration(const CalibratorConfig& config, FitsRun fits_run)
    : config_(config),
      fits_run_(fits_run),
      initializer_(config.initializer),
      search_(config),
      record_fit_(config.initializer) {}

AssociationOutcome MountCalibration::process(const Frame& frame) {
  is_work_due_ = false;
  motion_since_observation_ = append(motion_since_observation_, frame.motion);
  way_m_ += motionOf(frame.motion.distance_m, frame.motion.rotation_rad);
  picker_.move(frame.motion);
  search_.move(frame.motion);
  AssociationOutcome outcome = AssociationOutcome::of(frame);
  if (tracker_) {
    tracker_->move(withNoise(frame.motion, noise_));
    const double range_m = tracker_->filter().estimate().cartesian().range();
    const Association association = tracker_->fuse(
        withNoise(frame.image.candidates, noise_, range_m), frame.nearby, mayBeOthers());
    follow(association, frame, &outcome);
  }
  if (!started_) start(frame, &outcome);
  if (outcome.kind == Association::Kind::kFound) {
    last_seen_ = frame.image.stamp;
    last_seen_at_m_ = way_m_;
  }
  return outcome;
}

/// Nothing is known yet, or only an earlier mount that a filter works on meanwhile.
void MountCalibration::start(const Frame& frame, AssociationOutcome* outcome) {
  const Association choice = picker_.pick(frame.image.candidates, mayBeOthers());
  if (choice.kind == Association::Kind::kNothingSeen) return;
  const Bearing& light = frame.image.candidates[choice.candidate];
  outcome->note(choice.kind, light);
  if (choice.kind != Association::Kind::kFound) {
    outcome->lost_light = mayBeOthers() && picker_.isLost();
    if (outcome->lost_light) startAnew();
    return;
  }
  noteLight(light);
  remember(light, frame);
  if (!tracker_) ++bearings_used_;
  if (earlier_ && !search_.hasAttempted() && !tracker_) startFromEarlier(light);
  is_work_due_ = search_.isDue(initializer_.record());
  if (is_work_due_ && fits_run_ == FitsRun::kAtOnce) work();
}

void MountCalibration::work() {
  is_work_due_ = false;
  if (!started_) return attemptStart();
  if (isFitDue()) refineAndJudge();
  if (wantsDiagnosis()) {
    diagnose();
  } else {
    diagnosis_ = {};
  }
  if (config_.restart_on_mount_change && judge_->last().cause == Fault::kMountMoved) {
    restarted_ = true;
    earlier_.reset();  // nothing of the old mount holds any longer
    startAnew();
  }
}

void MountCalibration::attemptStart() {
  const StartAttempt& attempt = search_.attempt(initializer_);
  rival_ = attempt.rival;
  if (search_.isInVain()) diagnose();
  if (!attempt.ready()) return;
  noise_ = attempt.noise;
  noise_start_ = unknownsWith(noise_);
  if (isNoiseSurprising()) {
    if (!diagnoses_.isDue(initializer_.record())) return;  // not before a fault was looked for
    diagnose();
    if (diagnosis_.fault != Fault::kNone) return search_.refute();
  }
  diagnosis_ = {};
  const std::vector<Observation>& observations = initializer_.record().observations();
  record_fit_.beginAt({attempt.estimate, observations.size() - 1}, observations);
  tracker_.emplace(config_.filter, withEarlier(attempt.estimate), attempt.bearing_correlation);
  judge_.emplace(config_.converged, config_.initializer.batch.errors);
  started_ = true;
}

/// What an earlier calibration knows is followed until the observations tell by themselves.
void MountCalibration::startFromEarlier(const Bearing& light) {
  constexpr double kUncorrelated = 0.0;
  constexpr LightDistance kSomewhereNear{2.0, 1.0};  // corrected by the first metre driven
  const ErrorPriors& errors = config_.initializer.batch.errors;
  tracker_.emplace(config_.filter,
                   StateEstimate::of(placeLight(earlier_->mount(), kSomewhereNear,
                                                light.azimuth_rad, light.azimuth_variance_rad2),
                                     errorsInUse(errors), priorEstimate(errors)),
                   kUncorrelated);
}

/// After the tracker has seen an image.
void MountCalibration::follow(const Association& association, const Frame& frame,
                              AssociationOutcome* outcome) {
  if (association.kind == Association::Kind::kNothingSeen) return;
  const bool found = association.kind == Association::Kind::kFound;
  const Bearing& light = frame.image.candidates[association.candidate];
  outcome->note(association.kind, light);
  ++(found ? bearings_used_ : bearings_gated_);
  if (found) noteLight(light);
  if (started_) judge_->doubt(tracker_->consistency());
  if (started_ && (found || !mayBeOthers())) {
    remember(light, frame);
    is_work_due_ = isFitDue() || (wantsDiagnosis() && diagnoses_.isDue(initializer_.record()));
    if (is_work_due_ && fits_run_ == FitsRun::kAtOnce) work();
    if (!started_) return;  // the mount has moved
  }
  if (!tracker_->isLost() || tracker_->isSearching()) return;
  outcome->lost_light = started_;
  tracker_.reset();
  if (started_) startAnew();
}

/// For the other lights, after the judge has spoken.
void MountCalibration::noteSolution(const std::optional<SlipAverage>& settled,
                                    const StateEstimate& estimate) {
  const Judgement& judgement = judge_->last();
  if (judgement.cause == Fault::kMountMoved && !mount_moved_at_m_) mount_moved_at_m_ = way_m_;
  const std::vector<Observation>& observations = initializer_.record().observations();
  if (settled) {
    answer_ = LandmarkSolution{{}, settled->best, estimate, noise_};
    for (const Observation& observation : observations)
      answer_->stamps.push_back(observation.stamp);
  }
  const bool is_refuted = judgement.state == CalibrationState::kInconsistent ||
                          (settled && (settled->rival.isOpen() ||
                                       !tellsOneMount(*tracker_, observations, settled->best)));
  if (is_refuted) {
    is_sound_ = false;
    one_mount_since_m_.reset();
    return;
  }
  if (!settled) return;
  const double motion_m = motionOf(observations, settled->best.beginning);
  if (!one_mount_since_m_) one_mount_since_m_ = motion_m;
  is_sound_ = motion_m - *one_mount_since_m_ >= kHeldOver_m;
}

std::optional<double> MountCalibration::movedFor() const {
  if (!mount_moved_at_m_) return std::nullopt;
  return way_m_ - *mount_moved_at_m_;
}

bool MountCalibration::isFitDue() const {
  const ObservationRecord& record = initializer_.record();
  return fits_.isDue(record) || (fits_.isTime(record) && doubtAbout(tracker_->consistency()));
}

/// The filter cannot take back what it has once believed: a slip that passed the gate, a bearing
/// that was none. The batch over the record can, and knows about them by what came after.
void MountCalibration::refineAndJudge() {
  const ObservationRecord& record = initializer_.record();
  fits_.begin(record, fitPace(config_.refit_growth));
  const std::vector<Observation> observations = withNoise(record.observations(), noise_);
  const std::optional<SlipAverage> settled =
      record_fit_.fit(observations, tracker_->filter().estimate(), record.beginning());
  std::optional<NoiseReview> review;
  StateEstimate estimate;
  if (settled) {
    rival_ = settled->rival;
    review = reviewNoiseOf(*settled);
    estimate = review ? changedAs(settled->estimate, settled->best.last, review->average)
                      : settled->estimate;
    if (!tracker_->isSearching()) {
      tracker_->rebase(withEarlier(widened(estimate, settled->best.scatter().widening())),
                       settled->best.correlation);
    }
  }
  judge_->judge(*tracker_, observations, settled, noiseMargin(review ? review->levels : noise_));
  if (config_.max_lights > 1) noteSolution(settled, estimate);
  if (judge_->last().state == CalibrationState::kConverged) most_noise_ = mostNoise();
  const std::size_t cut = settled ? RecordFit::cutOf(*settled, surplus()) : 0;
  if (cut == 0) return;
  std::optional<StateEstimate> average;
  if (review) {
    average = averageAfter(cut, record.observations(), settled->trusting,
                           config_.initializer.batch.errors, *review);
    noise_told_before_.give(static_cast<double>(cut) / static_cast<double>(observations.size()),
                            review->told);
  }
  initializer_.cut(record_fit_.oldestPart(observations, settled->trusting, cut, average));
}

/// Of several lights each record is as long as the one that they share.
std::size_t MountCalibration::surplus() const {
  const ObservationRecord& record = initializer_.record();
  if (config_.max_lights == 1) return record.surplus();
  const auto shared = std::find_if(
      record.observations().begin(), record.observations().end(),
      [this](const Observation& observation) { return observation.stamp >= shared_since_; });
  return std::min(record.surplus(),
                  static_cast<std::size_t>(shared - record.observations().begin()));
}

/// What a fit says when nobody knows the noise. The levels are for the next fit: all hypotheses of
/// one must be weighed alike.
std::optional<NoiseReview> MountCalibration::reviewNoiseOf(const SlipAverage& settled) {
  const std::vector<Observation>& observations = initializer_.record().observations();
  const InitializerConfig& config = config_.initializer;
  correlation_time_ = correlationTime(observations, settled.best.correlation);
  if (!config.noise.any()) return std::nullopt;
  const auto review = reviewNoise(observations, settled.best, config.batch.errors, config.noise,
                                  noise_start_, noise_told_before_);
  if (!review) return std::nullopt;
  noise_start_ = review->likeliest;
  noise_ = most_noise_ ? atMost(review->levels, *most_noise_) : review->levels;
  return review;
}

/// A light may grow dim, so that its bearings are as noisy as found; wheels stay as they were.
NoiseMargin MountCalibration::noiseMargin(const NoiseLevels& found) const {
  const NoiseLevels at_jump{found.atMost().bearing, mostNoise().wheel};
  return {noise_.atMost().varianceOver(noise_), at_jump.varianceOver(noise_)};
}

/// An estimate from the observations, with the earlier calibration unless they contradict it: then
/// that one is forgotten. It is as uncertain as both doubt what was known beforehand.
StateEstimate MountCalibration::withEarlier(StateEstimate estimate) {
  constexpr double kFalseAlarm = 1e-4;
  if (earlier_ && disagreement(estimate.mount(), earlier_->mount()) >
                      chiSquareQuantile(1.0 - kFalseAlarm, 3.0)) {
    earlier_.reset();
  }
  if (earlier_) addEarlier(*earlier_, config_.initializer.batch.errors, &estimate);
  return withDoubtOfLengths(estimate, config_.initializer.batch.errors);
}

bool MountCalibration::wantsDiagnosis() const {
  return judge_->last().state == CalibrationState::kInconsistent || isNoiseSurprising();
}

/// Which single fault of the robot would explain the record.
void MountCalibration::diagnose() {
  if (!diagnoses_.isDue(initializer_.record())) return;
  diagnoses_.begin(initializer_.record(), kDiagnoses);
  diagnosis_ = findFault(initializer_.record().observations(), config_.drive.wheel_separation_m,
                         config_.initializer,
                         most_noise_ ? config_.initializer.batch.errors : ErrorPriors{});
  // A light that moves is given up like a slip: a jump of the mount that remains is not due to it.
  const bool has_moved = judge_ && judge_->last().cause == Fault::kMountMoved;
  if (has_moved && diagnosis_.fault == Fault::kLightMoved) diagnosis_ = {};
}

/// Keeps an observation: for the initialiser before the start, for batch and judge after it.
void MountCalibration::remember(const Bearing& light, const Frame& frame) {
  initializer_.add({frame.image.stamp, motion_since_observation_, light.azimuth_rad,
                    light.azimuth_variance_rad2, frame.nearby, elevationOf(light)});
  motion_since_observation_ = {};
}

void MountCalibration::noteLight(const Bearing& light) {
  if (light.light_id != kUnknownLight) light_id_ = light.light_id;
}

/// Forgets what the observations have said, but not which light it is, nor what is said about it
/// all.
void MountCalibration::startAnew() {
  MountCalibration fresh(config_, fits_run_);
  fresh.earlier_ = earlier_;
  fresh.restarted_ = restarted_;
  fresh.light_id_ = light_id_;
  fresh.bearings_used_ = bearings_used_;
  fresh.bearings_gated_ = bearings_gated_;
  *this = std::move(fresh);
}

std::optional<AzimuthPrediction> MountCalibration::predictAzimuthAfter(
    const OdometryIncrement& motion, const OdometryWindow& nearby) const {
  if (!tracker_ || tracker_->isSearching()) return std::nullopt;
  return tracker_->predictAzimuthAfter(withNoise(motion, noise_), nearby);
}

}  // namespace bearing_calibration::core
