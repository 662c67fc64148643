#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/record/record_beginning.h"
#include "bearing_calibration/solve/mount_displacement.h"
#include "bearing_calibration/solve/record_track.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

struct BatchEstimate;

/// How a whole record is weighed.
struct BatchConfig {
  /// Residuals beyond so many standard deviations count linearly, not squared (Huber); 0 is off.
  double huber_sigmas = 2.0;
  /// Once the fit has settled, observations whose residual from all others exceeds so many standard
  /// deviations are left out; 0 is off.
  double reject_sigmas = 3.5;
  /// Gain in chi-square (2 degrees of freedom) for which a motion between two observations as far
  /// apart as they mostly are is declared a slip and given up; for a longer one, less; 0 is off.
  double slip_gain = 20.0;
  /// Estimates the correlation of neighbouring bearings' noise and widens their variance with it.
  bool widen_for_correlation = true;
  /// The correlation as another fit of the record has found it, to be compared with that one by
  /// their costs; none: as this one finds it.
  std::optional<double> correlation;
  ErrorPriors errors;  ///< those of the robot that are estimated with the mount

  /// Least squares: every bearing counts for what it says, and nothing slips.
  static BatchConfig leastSquares(const ErrorPriors& errors = {});
  /// The same for fits that are compared with one: where each was widened by the correlation that
  /// its own misfit makes, a wrong one would be cheap.
  BatchConfig weighedAs(const BatchEstimate& fit) const;
  void declare(Parameters& params);
};

/// What is supposed about slips before a fit: it looks for further ones by itself.
struct SlipHypothesis {
  std::vector<std::size_t> given_up;  ///< observations whose motions are given up
  std::vector<std::size_t> trusted;   ///< observations whose motions, and those near, are not
  double least_gain = 0.0;            ///< of a further slip; 0: what a fit asks for by itself
  bool at_its_cost = false;           ///< a further slip need only be worth its cost
  int most_further = std::numeric_limits<int>::max();
};

/// What a record of observations says about the mount and the light.
struct BatchEstimate {
  StateEstimate last;  ///< at the last observation
  bool converged = false;
  double chi_square = 0.0;     ///< of the observations that were used, innovations of the last pass
  int degrees_of_freedom = 0;  ///< of chi_square: observations used less what was estimated
  double cost = std::numeric_limits<double>::infinity();  ///< robust cost of all observations and
                                                          ///< slips: what two fits compare by
  std::vector<double> nis;  ///< of each observation given those before it, by the variance
                            ///< that the sensor says; NaN where left out
  RecordPath path;          ///< smoothed
  std::vector<std::size_t> rejected;  ///< indices of observations left out
  std::vector<std::size_t> slips;     ///< indices of observations whose motion was given up
  std::vector<MountDisplacement> mount_displacements;  ///< before each observation
  double suspicion = 0.0;    ///< largest gain that giving up one more would have
  double correlation = 0.0;  ///< lag-1 correlation of the innovations, 0 where insignificant
  std::vector<ObservationWeight> weights;    ///< of each observation, in the end
  std::optional<RecordBeginning> beginning;  ///< of the record, where it had one

  /// Whether it has converged, and uses so much of the observations.
  bool hasSettled(double min_inlier_fraction) const;
  /// Of the mounts that the parts of the drive tell, what the record has given away counted.
  Scatter scatter() const;
  /// What is known at the record's beginning; null where that is nothing.
  const StateEstimate* known() const { return beginning ? &beginning->known : nullptr; }
};

/// Where another fit of the same record had best begin, or one that has grown: in the middle of the
/// longest stretch without a slip. After a slip near the end it may be another light that is seen.
/// @param fit  with a path
RecordStart surestStart(const BatchEstimate& fit);

/// The most probable mount, lights and path given all bearings and the noise of all wheel motions:
/// Gauss-Newton on the Cartesian state by relinearised Kalman smoother passes (start.md,
/// section "Batch").
class BatchEstimator {
 public:
  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit BatchEstimator(const BatchConfig& config);

  /// @param observations in the order of time; the motion of the first is used with a beginning
  /// only.
  /// @throws std::invalid_argument when the start or a supposed slip is at no observation, a
  /// variance
  ///   is not positive, or the beginning is not of the start's lights and the errors in use.
  BatchEstimate estimate(const std::vector<Observation>& observations, const RecordStart& start,
                         const SlipHypothesis& slips = {},
                         const std::optional<RecordBeginning>& beginning = std::nullopt) const;

  /// The same from a track of these observations.
  BatchEstimate estimate(const std::vector<Observation>& observations, const RecordTrack& track,
                         const SlipHypothesis& slips = {},
                         const std::optional<RecordBeginning>& beginning = std::nullopt) const;

  /// The estimate at an observation from everything until there, linearised and weighed as a fit of
  /// the whole record is.
  /// @param observations,fit  a record and its fit
  StateEstimate filteredAt(std::size_t observation, const std::vector<Observation>& observations,
                           const BatchEstimate& fit) const;
  /// The same as what a record that is cut after it begins with (withoutLearntScale()).
  /// @param average  of what the fit says there, over all noise; none where that is known
  StateEstimate knownAt(std::size_t observation, const std::vector<Observation>& observations,
                        const BatchEstimate& fit,
                        const std::optional<StateEstimate>& average = std::nullopt) const;

 private:
  BatchConfig config_;
};

}  // namespace bearing_calibration::core
