#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/record/observation_record.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/noise_levels.h"
#include "bearing_calibration/solve/observability.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {

/// When a start may be trusted. The estimate must be well inside the range where a linearised
/// filter carries on from it.
struct InitializerConfig {
  int min_observations = 20;
  double min_extent_m =
      0.4;  ///< of the path, which noise alone does not make: enough for any robot
  /// A smaller one is enough, too, where it is so many times what the wheels' noise makes: a random
  /// walk's is 2.3, and hardly ever above 4.5; and so much of the light's distance.
  double min_extent_per_noise = 5.0;
  double min_extent_per_range = 0.1;
  double min_path_per_range = 0.2;  ///< path over the light's distance
  double min_turn_rad = 0.5;
  double min_second_curvature_m = 0.15;  ///< see MotionSummary; more than an encoder's noise makes
  double max_position_stddev_m = 0.03;   ///< sensor x and y
  double max_position_stddev_per_extent = 0.1;  ///< of the path
  double max_yaw_stddev_rad = 0.1;
  double max_light_stddev_per_range = 0.15;
  double min_light_distance_m = 0.2;   ///< from the sensor, at the last observation
  double max_chi_square_sigmas = 6.0;  ///< chi-square < n + this * sqrt(2 n)
  double min_inlier_fraction = 0.6;
  double min_runner_up_margin = 25.0;  ///< cost of the next best answer above the best one
  std::uint32_t seed = 1;              ///< of the random draws: the same record, the same answer
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
  kLightTooNear,   ///< the light is (nearly) over the sensor at the last observation
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
  double inlier_fraction = 0.0;
  RivalMount rival;
  int slips = 0;
  double bearing_correlation = 0.0;
  NoiseLevels noise;  ///< against the stated one, where it is looked for

  bool ready() const { return obstacle == StartObstacle::kNone; }
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

  void add(const Observation& observation) { record_.add(observation); }
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
