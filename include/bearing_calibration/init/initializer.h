#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/record/observation_record.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/observability.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {

/// What a start is made of. When it may be trusted: StartLimits.
struct InitializerConfig {
  double min_inlier_fraction = 0.6;
  /// Begins from several robots, late ones and ones with other wheels, as far as batch.errors says
  /// that there may be such; else from the robot as believed.
  bool search_errors = true;
  ObservationRecordConfig record;
  BatchConfig batch;
  NoisePriors noise;

  void declare(Parameters& params);
};

/// Why there is no start yet, from the first thing to change to the last.
enum class StartObstacle : std::uint8_t {
  kNone,  ///< ready
  kTooFewObservations,
  kTooShortPath,   ///< standing, or turning on the spot only
  kNoTurn,         ///< one straight line
  kOneCurvature,   ///< one circle: a second curvature is needed
  kNoSolution,     ///< no mount explains the bearings, or the fit did not settle
  kPoorFit,        ///< residuals larger than their noise, or too many outliers
  kLightTooNear,   ///< the sensor is (nearly) over the light at the last observation, or often was
  kWeakDirection,  ///< a direction is not yet determined: see weakest
  kAmbiguous,      ///< a second answer explains the bearings about as well
};

/// "too few observations" and so on.
const char* nameOf(StartObstacle obstacle);

/// An attempt to find mount and light from nothing but bearings and odometry.
struct StartAttempt {
  StartObstacle obstacle = StartObstacle::kTooFewObservations;
  /// At the last observation. With an obstacle it is the best guess so far, and only for display;
  /// it is empty where there was no solution.
  StateEstimate estimate;
  MotionSummary motion;
  WeakestDirection weakest;  ///< of the estimate
  double chi_square = 0.0;
  int degrees_of_freedom = 0;
  RivalMount rival;
  double bearing_correlation = 0.0;
  NoiseLevels noise;  ///< against the stated one, where it is looked for
  /// Of the record with it, minus the logarithm of its likelihood; infinite where nothing fits.
  double noise_cost = std::numeric_limits<double>::infinity();

  bool ready() const { return obstacle == StartObstacle::kNone; }
  /// Whether a mount explains the bearings, though it may not be known well enough yet.
  bool fits() const { return ready() || obstacle >= StartObstacle::kLightTooNear; }
};

/// One attempt on a given record; Initializer is this with a bounded record.
/// @param observations in the order of time; the motion of the first is not used.
/// @param noise_before  levels to begin with, where they are looked for
StartAttempt findStart(const std::vector<Observation>& observations,
                       const InitializerConfig& config, const NoiseLevels& noise_before = {});

/// Levels to begin with where nothing is known of the mount.
NoiseLevels noiseToBeginWith(const std::vector<Observation>& observations,
                             const NoisePriors& priors);

/// Collects observations and finds the start of the filter in them, whatever the mount and wherever
/// the light. Bounded in memory and time on an endless record.
class Initializer {
 public:
  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit Initializer(const InitializerConfig& config);

  /// The motion before the first one counts as none: nothing was seen meanwhile.
  void add(Observation observation) {
    if (record_.observations().empty()) observation.motion = {};
    record_.add(observation);
  }
  /// Milliseconds of work: call it about once in a second, not at each observation.
  /// @param noise_before  of an earlier attempt that found an answer; else none
  StartAttempt attempt(const std::optional<NoiseLevels>& noise_before = std::nullopt) const {
    const std::vector<Observation>& observations = record_.observations();
    return findStart(observations, config_,
                     noise_before.value_or(noiseToBeginWith(observations, config_.noise)));
  }
  /// See ObservationRecord::cut(). A start is looked for in whole records only.
  void cut(const RecordPart& part) { record_.cut(part); }

  const ObservationRecord& record() const { return record_; }

 private:
  InitializerConfig config_;
  ObservationRecord record_;
};

}  // namespace bearing_calibration::core
