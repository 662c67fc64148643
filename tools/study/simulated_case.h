#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/robot_errors.h"
#include "bearing_calibration/noise/noise_levels.h"
#include "bearing_calibration/simulation/robot_simulator.h"
#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {

/// What a robot may be that none of the estimators' models knows, beside the errors and the noise
/// that they look for.
enum class Unmodelled : std::uint8_t {
  kNone,
  kSwingingSeparation,  ///< the wheels' separation swings by 3 % in 37 s
  kSenseOfTurn,         ///< it is 1.5 % larger to the left than to the right
  kDriftingTyre,        ///< the left wheel grows by 0.6 % over the run
  kLastingNoise,        ///< the bearings' noise has a correlation time of 3 s
  kHeavyTails,          ///< it is Student's t with 3 degrees of freedom
  kCoarseTicks,         ///< a tick is 1 mm
  kTwoGrips,            ///< on every other stripe of the floor the wheels are 25 times as noisy
  kLateTicks,           ///< the ticks are stamped on arrival, 10 ms late in the mean
  kLaterTicks,          ///< 30 ms late
};

/// One robot, one light and one way to drive: everything that a run is made of.
struct SimulatedCase {
  RobotConfig robot;
  std::vector<Light> lights;  ///< the first is the one that the mount is calibrated with
  TrajectoryConfig trajectory;
  double duration_s = 100.0;
  Unmodelled unmodelled = Unmodelled::kNone;
  std::function<void(SimulatedRecord*)> change_record;  ///< what a fault makes of it; may be empty
  double hide_in_turn_s = 0.0;    ///< so long each of several numbered lights is hidden, in turn
  bool are_lights_told = true;    ///< the calibrator gets the numbers that the sensor gives
  NoiseLevels stated_noise;       ///< what the calibrator is told of the noise, times the true one
  bool fit_whole_record = false;  ///< what the calibrator forgets is measured, too
  NoisePriors noise_looked_for;   ///< by the calibrator
  ErrorPriors looked_for;         ///< errors of the robot that the estimators are told to look for
};

/// The settings of the paper's section V: its mount, light, noise and second trajectory.
SimulatedCase paperCase(std::uint64_t seed);

/// The same robot, its dance about a square inside of which the light stands, a quarter of a metre
/// from two of the sides: what a person should drive (driving.md).
SimulatedCase cornerCase(std::uint64_t seed);

/// A short drive with a noisy sensor, as in a published simulation of active calibration: a source
/// at 3.6 m, bearings of 2 degrees (0.02 rad stated), wheels of 2 % in each step of 8 mm (K = 1e-6
/// m stated), and in 35 s 6 m and 560 degrees of turns.
SimulatedCase shortCase(std::uint64_t seed);

/// What is drawn at random beside the noise.
struct RandomCaseRange {
  double max_mount_distance_m = 1.0;
  double min_light_distance_m = 0.3;  ///< from the base's start
  double max_light_distance_m = 10.0;
};

/// A mount of any direction and yaw, a light anywhere and a robot of any heading: uniform in all
/// of them (the light's distance in its logarithm, so that near and far are as frequent).
SimulatedCase randomCase(std::uint64_t seed, TrajectoryConfig::Kind kind,
                         const RandomCaseRange& range);

/// A drive that cannot tell the mount, by the seed in turn: standing, a line, back and forth, a
/// circle, a spin, a line through the light, a circle about the light; all else as in randomCase.
SimulatedCase degenerateCase(std::uint64_t seed);

/// `count` slips of one wheel, 0.2 to 0.5 s long and 30 to 70 % off, anywhere in the run.
void addSlips(SimulatedCase& simulated, int count, std::uint64_t seed);

/// How far off a robot is.
struct ImperfectRobot {
  double time_offset_s = 0.0;        ///< stamps are late by this
  double ratio = 0.0;                ///< of the right wheel's scale over the left one's, less 1
  double scale = 0.0;                ///< of both wheels together, less 1
  double max_random_offset_s = 0.0;  ///< added to the offset: uniform from 0 to this
  double random_ratio_stddev = 0.0;  ///< added to the ratio
  double random_separation_stddev = 0.0;  ///< of the true wheel separation over the believed one
  double tilt_rad = 0.0;                  ///< of the sensor, in a direction drawn at random
  double harmonic_rad = 0.0;              ///< of the mirror, its phase drawn at random
  double random_scale_stddev = 0.0;       ///< added to the scale
};

/// Makes the robot of a case an imperfect one.
void makeImperfect(SimulatedCase& simulated, const ImperfectRobot& how, std::uint64_t seed);

/// Makes a robot noisier or less so than what it is stated to be: bearings by a factor of 1/3 to 4,
/// the wheels' variance by one of 1/10 to 100, uniform in their logarithms; bearings correlated by
/// 0 to 0.8.
void drawNoise(SimulatedCase& simulated, std::uint64_t seed);

/// Hides the light for a share of the run, in stretches of some seconds anywhere.
void addOcclusions(SimulatedCase& simulated, double share, std::uint64_t seed);

/// What the calibration's parameters look for by default (config/calibration.yaml), but for the
/// separation: to 2 %.
ErrorPriors usualErrors();

NoisePriors usualNoise();

/// The robot's errors as the blocks of the estimators count them.
ErrorVector trueErrors(const SimulatedCase& simulated);

struct TrueState {
  Stamp stamp;
  Vector5 cartesian = Vector5::Zero();
  Pose2 world_from_base;
};

/// What an estimator gets of a run, and the truth.
struct ObservationRun {
  SimulatedRecord record;                 ///< raw: ticks and bearings
  std::vector<Observation> observations;  ///< one candidate per image, with the motion between them
  std::vector<Vector5> truth;             ///< Cartesian state at each observation
  std::vector<Pose2> world_from_base;     ///< true pose at each observation
  std::vector<TrueState> at_images;  ///< the same at each image, whether it shows the light or not
};

ObservationRun simulate(const SimulatedCase& simulated);
/// The same along another trajectory than the case's own.
ObservationRun simulateAlong(const SimulatedCase& simulated, Trajectory trajectory);

/// A record as the estimators get it, with its truth.
ObservationRun runFromRecord(const SimulatedCase& simulated, SimulatedRecord record);

/// The observations of a record, with the travel around each: each bearing of the first candidate
/// with the motion since the last.
std::vector<Observation> observationsFromRecord(const SimulatedRecord& record,
                                                const DriveGeometry& drive,
                                                const WheelNoise& noise);

}  // namespace bearing_calibration::core
