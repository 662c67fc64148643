#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/joint_record.h"
#include "bearing_calibration/calibration/record_fit.h"
#include "bearing_calibration/calibration/schedule.h"
#include "bearing_calibration/calibration/start_search.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "bearing_calibration/noise/noise_review.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/track/association_outcome.h"
#include "bearing_calibration/track/light_picker.h"
#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {

/// The calibration by one light from its first observation on: the base's motion and what each
/// image saw, in the order of time; the mount out. Collects observations until the initialiser
/// finds mount and light in them, goes on with the filter, holds the filter against the record once
/// a second, and judges. A full record gives its oldest part away as what that part says. A value:
/// a copy goes on by itself.
class MountCalibration {
 public:
  /// @param fits_run  kBeside: process() leaves what is heavy to work()
  explicit MountCalibration(const CalibratorConfig& config, FitsRun fits_run = FitsRun::kAtOnce);

  /// Goes on from a mount that an earlier calibration has found, as long as the observations agree
  /// with it. To be called before the first observation.
  void resume(const StateEstimate& earlier) { earlier_ = earlier; }

  /// @param frame  with what can be this light
  /// @returns what became of it
  AssociationOutcome process(const Frame& frame);

  /// Whether the last image has made heavy work due that is not done.
  bool isWorkDue() const { return is_work_due_; }
  /// Does it. To be called before the next image only: what fits say is of the last one.
  void work();

  /// What is older is no longer shared with other lights, whose record has given it away.
  void shareSince(Stamp stamp) { shared_since_ = stamp; }
  Stamp lastSeen() const { return last_seen_; }
  /// How far the robot has gone since, its turns counted [m].
  double unseenFor_m() const { return way_m_ - last_seen_at_m_; }
  /// Carries on from a start.
  bool isFound() const { return started_; }
  /// Its own answer has stood for as long as a verdict on it alone would have to: all that makes
  /// such a verdict honest, but for how well the mount is known.
  bool isSound() const { return is_sound_ && !isRefuted(); }
  /// How far the robot has gone, its turns counted, since it says that the mount has moved; none
  /// where it does not say so [m].
  std::optional<double> movedFor() const;
  /// Why other lights do not count it in; empty when nothing speaks against it.
  std::string obstacle() const;

  /// Where the light would be seen after a further motion; none before the first estimate, or while
  /// the light is looked for.
  std::optional<AzimuthPrediction> predictAzimuthAfter(const OdometryIncrement& motion,
                                                       const OdometryWindow& nearby) const;
  /// The light that is followed, where the sensor tells lights apart.
  std::int32_t lightId() const { return light_id_.value_or(kUnknownLight); }

  /// The last fit that settled; none before, and where nobody asks for it
  /// (CalibratorConfig::max_lights is 1).
  const std::optional<LandmarkSolution>& solution() const { return answer_; }
  /// The light at the last image, once a start was found.
  Eigen::Vector2d lightInBase() const { return tracker_->filter().estimate().mean.tail<2>(); }
  /// What the judge says; null before the start.
  const Judgement* judgement() const { return judge_ ? &judge_->last() : nullptr; }
  const std::optional<StateEstimate>& earlier() const { return earlier_; }
  const NoiseLevels& noise() const { return noise_; }  ///< against the stated one
  /// Of the last attempt to start, or of the last fit.
  const RivalMount& rival() const { return rival_; }

  /// Fills in what the observations have told: state, advice, estimates, consistency, counts of
  /// bearings.
  void describe(CalibrationResult* result) const;

 private:
  /// Without numbers, what does not fit this light is of another one, and no slip.
  bool mayBeOthers() const { return config_.max_lights > 1 && !light_id_; }
  void start(const Frame& frame, AssociationOutcome* outcome);
  void attemptStart();
  void startFromEarlier(const Bearing& light);
  StateEstimate withEarlier(StateEstimate estimate);
  void follow(const Association& association, const Frame& frame, AssociationOutcome* outcome);
  bool isFitDue() const;
  void refineAndJudge();
  std::size_t surplus() const;
  void noteSolution(const std::optional<SlipAverage>& settled, const StateEstimate& estimate);
  std::optional<NoiseReview> reviewNoiseOf(const SlipAverage& settled);
  bool isNoiseSurprising() const { return config_.initializer.noise.isSurprisedBy(noise_); }
  /// More noise would explain the record as well: it is not what was stated, and a fault is.
  bool isRefuted() const {
    return started_ && isNoiseSurprising() && diagnosis_.fault != Fault::kNone;
  }
  NoiseLevels mostNoise() const {
    return most_noise_ ? atMost(noise_.atMost(), *most_noise_) : noise_.atMost();
  }
  /// @param found  in the record, whether or not so much is taken for noise
  NoiseMargin noiseMargin(const NoiseLevels& found) const;
  bool wantsDiagnosis() const;
  void diagnose();
  void noteLight(const Bearing& light);
  void remember(const Bearing& light, const Frame& frame);
  void startAnew();

  CalibratorConfig config_;
  FitsRun fits_run_;
  bool is_work_due_ = false;
  std::optional<StateEstimate> earlier_;  ///< taken up, and not contradicted so far
  LightPicker picker_;
  Initializer initializer_;  ///< keeps the record, after the start too
  StartSearch search_;
  RecordFit record_fit_;                        ///< after the start
  Stamp shared_since_;                          ///< until then nothing of the record is given away
  OdometryIncrement motion_since_observation_;  ///< since the record's last one
  Schedule fits_;
  Schedule diagnoses_;
  Diagnosis diagnosis_;  ///< the fault that would explain why nothing fits
  std::optional<MountTracker> tracker_;
  std::optional<ConvergenceJudge> judge_;  ///< of tracker_, once started
  std::optional<LandmarkSolution> answer_;
  std::optional<double> one_mount_since_m_;  ///< motion of the record when answer_ told one first
  bool is_sound_ = false;
  double way_m_ = 0.0;                      ///< of the robot, its turns counted
  std::optional<double> mount_moved_at_m_;  ///< way_m_ when the judge said so first
  Stamp last_seen_;
  double last_seen_at_m_ = 0.0;  ///< way_m_
  bool started_ = false;         ///< tracker_ carries on from the initialiser
  bool restarted_ = false;       ///< since the mount has moved
  NoiseLevels noise_;            ///< against the stated one, as the drive has it
  NoiseUnknowns noise_start_ = NoiseUnknowns::Zero();  ///< where the next search for it begins
  NoiseInformation noise_told_before_;                 ///< by what has been given away of it
  /// Once CONVERGED: what would take more is not noise, but a change.
  std::optional<NoiseLevels> most_noise_;
  CorrelationTime correlation_time_;
  RivalMount rival_;
  std::optional<std::int32_t> light_id_;
  std::uint32_t bearings_used_ = 0;
  std::uint32_t bearings_gated_ = 0;
};

}  // namespace bearing_calibration::core
