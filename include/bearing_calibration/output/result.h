#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/filter/paper_filter.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/judge/calibration_state.h"
#include "bearing_calibration/judge/fault.h"
#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {

/// The part of the sensor's pose in the base frame that bearings of one light in the plane say
/// nothing about. It is configured and passed on, never estimated. Parameter group `mount`.
struct UnestimatedMount {
  double z_m = 0.0;
  double z_stddev_m = 0.0;  ///< > 0, like the other two: nothing is known exactly
  double roll_rad = 0.0;
  double roll_stddev_rad = 0.0;
  double pitch_rad = 0.0;
  double pitch_stddev_rad = 0.0;

  void declare(Parameters& params);
};

/// Where odometry has the base at a moment, in the base frame of the first image.
struct BasePlace {
  Stamp stamp;  ///< on the encoders' clock
  Pose2 start_from_base;
};

/// One of the lights that the mount is calibrated with.
struct LightSummary {
  std::int32_t light_id = kUnknownLight;                     ///< the sensor's number for it
  CalibrationState state = CalibrationState::kInitialising;  ///< of its own calibration
  std::optional<CartesianEstimate> cartesian_state;          ///< with the mount; none before one
  bool in_estimate = false;  ///< the mount that is published rests on it
  std::uint32_t bearings_used = 0;
  std::string note;  ///< why it is not in the estimate; empty otherwise
};

/// What the calibration knows after the last input.
struct CalibrationResult {
  CalibrationState state = CalibrationState::kWaitingForTicks;
  std::string advice;          ///< a sentence for the driver
  Fault cause = Fault::kNone;  ///< why it is inconsistent
  Stamp stamp;                 ///< of the last fused bearing, on the encoders' clock
  Pose2 start_from_base;       ///< at that stamp (BasePlace)
  std::optional<MountEstimate> base_from_sensor;     ///< none before the first estimate
  std::optional<PaperEstimate> paper_state;          ///< none before the first estimate
  std::optional<CartesianEstimate> cartesian_state;  ///< none before the first estimate

  ErrorPriors error_priors;    ///< which errors of the robot are looked for
  ErrorEstimate robot_errors;  ///< as their priors before the first estimate
  /// Mount, errors and lights, of which the last five are a part; none before the first estimate.
  std::optional<StateEstimate> estimate;

  std::vector<LightSummary> lights;  ///< all that are followed, in the order of their appearance
  NoisePriors noise_priors;          ///< which levels of the noise are looked for
  NoiseLevels noise;
  CorrelationTime correlation_time;  ///< of the bearings' noise
  RivalMount rival;                  ///< of several lights, by the one that is surest

  double nis = 0.0;       ///< of the last fused bearing
  double nis_mean = 0.0;  ///< running mean, 1 for a consistent filter
  double distance_travelled_m = 0.0;
  double rotation_travelled_rad = 0.0;

  std::uint32_t bearings_used = 0;
  std::uint32_t bearings_gated = 0;    ///< outside the gate, or ambiguous
  std::uint32_t bearings_waiting = 0;  ///< for the ticks that cover them
  std::uint32_t ticks_used = 0;
  InputCounts bearing_inputs;
  InputCounts tick_inputs;
};

/// Whether a state's mount may be used: CONVERGED or CONVERGING.
bool mayBeTrusted(CalibrationState state);

/// Fills in mount, light and the robot's errors, the mount as uncertain as the sensor's nearness in
/// error_priors leaves it.
void sayEstimate(const StateEstimate& estimate, CalibrationResult* result);

/// Adds to the advice that the calibration has begun again since the mount has moved, until it has
/// converged.
void sayRestarted(CalibrationResult* result);

}  // namespace bearing_calibration::core
