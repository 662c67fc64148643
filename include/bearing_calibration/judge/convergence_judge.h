#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/judge/calibration_state.h"
#include "bearing_calibration/judge/fault.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/slip_hypotheses.h"
#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {

/// When the calibration may call itself converged. Parameter group `converged`.
struct ConvergenceConfig {
  double position_stddev_m = 0.0;  ///< x and y each
  double yaw_stddev_rad = 0.0;

  void declare(Parameters& params);
};

/// What may be said of a running filter, with a sentence for the driver.
struct Judgement {
  CalibrationState state = CalibrationState::kConverging;
  std::string advice;
  Fault cause = Fault::kNone;  ///< of an inconsistency

  /// Takes CONVERGED back when the latest bearings speak against it, until the next judgement: the
  /// fit that it comes with tells why.
  void doubt(const Consistency& recent);
};

/// The first verdict is given when nothing has spoken against it over so much motion, which is a
/// straight metre and a turn: on a record of a few seconds the covariance is least certain.
inline constexpr double kHeldOver_m = 3.0;

/// Way with its turns, which count as those of a point half a metre from the centre.
double motionOf(double distance_m, double rotation_rad);
/// That of a record, from before its beginning on: what a verdict is held over.
template <class Entry>
double motionOf(const std::vector<Entry>& record, const std::optional<RecordBeginning>& beginning) {
  double motion_m = beginning ? motionOf(beginning->distance_m, beginning->rotation_rad) : 0.0;
  for (const Entry& entry : record) {
    motion_m += motionOf(entry.motion.distance_m, entry.motion.rotation_rad);
  }
  return motion_m;
}

/// Whether a mount is known as well as it must be for a verdict.
bool meetsTargets(const MountEstimate& mount, const ConvergenceConfig& config);

/// Of an estimate that does not meet the targets yet.
/// @param by  follows how well it is known, as in " by 3 lights"
/// @param cure  what to drive, unless wheels that are not as stated keep it from more
Judgement notYetConverged(const StateEstimate& estimate, const ErrorPriors& errors,
                          const std::string& by, const std::string& cure);

/// Whether a settled fit speaks of one mount throughout: the light is not lost, no two parts of the
/// record give different mounts, and both halves tell all of it.
bool tellsOneMount(const MountTracker& tracker, const std::vector<Observation>& record,
                   const BatchEstimate& settled);

/// What the latest bearings say against the filter, if anything.
/// @param more_variance  times the noise's variance that they may have
std::optional<std::string> doubtAbout(const Consistency& recent, double more_variance = 1.0);

/// The mount that was claimed last. A record that grows moves its answer within what was left open,
/// or it has been misread for a moment. What it then says counts when it goes on saying so.
class ClaimedMount {
 public:
  /// @returns CONVERGED, unless the mount has leapt
  /// @param motion_m  of the record
  Judgement claim(const MountEstimate& mount, double motion_m);

 private:
  struct Leap {
    MountEstimate to;
    double since_m;  ///< motion of the record when it first gave this one
  };
  bool staysWhereItWas(const MountEstimate& mount, double motion_m);

  std::optional<MountEstimate> claimed_;
  std::optional<Leap> leap_;
};

/// Factors by which the observations' variances may be larger than those that they have.
struct NoiseMargin {
  double scatter = 1.0;  ///< that the tracker's bearings may have
  double jump = 1.0;     ///< for a jump of the mount
};

/// Decides whether a filter that carries on from a good start has converged, and whether what it is
/// fed still fits. Converged needs all of: standard deviations within the targets, innovations that
/// are consistent, no slip elsewhere that would give another mount, and one mount in all of the
/// record: neither its two halves nor any other two parts of it say different ones; for the first
/// time, all of them over a metre and a turn. The last test goes on after convergence, so that a
/// displacement is noticed; a displaced mount stays inconsistent.
class ConvergenceJudge {
 public:
  /// @param errors  that are looked for, and what no bearing tells of the mount
  ConvergenceJudge(const ConvergenceConfig& config, const ErrorPriors& errors);

  /// @param record  the observations so far, thinned or not, or the latest of them
  /// @param settled  the batch over them with its rivals, which the tracker has just taken up; none
  ///   when it did not settle: nothing is called converged then
  /// @param margin  a scatter or a jump of the mount is named when that does not explain it
  void judge(const MountTracker& tracker, const std::vector<Observation>& record,
             const std::optional<SlipAverage>& settled, const NoiseMargin& margin = {});
  const Judgement& last() const { return last_; }
  /// The same between two judgements, with every bearing.
  void doubt(const Consistency& recent) { last_.doubt(recent); }

 private:
  Judgement decide(const MountTracker& tracker, const std::vector<Observation>& record,
                   const std::optional<SlipAverage>& settled, const NoiseMargin& margin);
  static Judgement mountMoved(const DisplacementTest& jump);
  Judgement stillConverging(const StateEstimate& estimate) const;

  ConvergenceConfig config_;
  ErrorPriors errors_;
  Judgement last_;
  std::optional<double> good_since_m_;  ///< motion of the record when nothing more was amiss
  bool confirmed_ = false;              ///< it was called converged
  ClaimedMount claimed_;
  std::optional<Judgement> mount_moved_;  ///< once the mount has moved after that
};

}  // namespace bearing_calibration::core
