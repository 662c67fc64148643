#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/simulation/light.h"
#include "bearing_calibration/simulation/robot_sensors.h"
#include "bearing_calibration/simulation/trajectory.h"

namespace bearing_calibration::core {

/// A stretch of time from the start of the simulation on.
struct TimeSpan {
  double start_s = 0.0;
  double duration_s = 0.0;
  bool contains(double time_s) const { return time_s >= start_s && time_s < start_s + duration_s; }
};

/// A wheel that turns by (1 + excess) of what it rolls over the ground: spins when excess > 0,
/// slides when excess < 0.
struct WheelSlip {
  enum class Wheel : std::uint8_t { kLeft, kRight };
  TimeSpan when;
  Wheel wheel = Wheel::kLeft;
  double excess = 0.0;
};

/// What goes wrong, and when.
struct RobotFaults {
  std::vector<WheelSlip> slips;
  std::vector<TimeSpan> occlusions;      ///< no light is seen
  std::vector<TimeSpan> lost_ticks;      ///< readings that never arrive; the counters count on
  std::vector<double> counter_resets_s;  ///< moments at which the driver counts from zero again

  void declare(Parameters& params);
};

/// A differential-drive robot with a bearing sensor.
struct RobotConfig {
  EncoderConfig encoders;
  double separation_factor = 1.0;  ///< true wheel separation over the believed one
  Pose2 base_from_sensor;
  Pose2 world_from_start;  ///< the base at time zero
  BearingSensorConfig sensor;
  /// The sensor's stamps say later than the moment of the measurement by this [s].
  double stamp_latency_s = 0.0;
  double step_s = 0.01;                 ///< of the motion: one exact arc each
  int steps_per_reading = 1;            ///< of the encoders
  int steps_per_bearing = 10;           ///< of the bearing sensor
  Stamp start = stampFromSeconds(1.0);  ///< stamp of time zero; zero itself is no stamp in ROS
  RobotFaults faults;
  std::uint64_t seed = 1;

  void declare(Parameters& params);
};

/// The true motion of a robot and what its encoders and its bearing sensor make of it.
class RobotSimulator {
 public:
  /// @throws std::invalid_argument with what errorsOf() says, or without a trajectory.
  RobotSimulator(const RobotConfig& config, std::vector<Light> lights, Trajectory trajectory);

  /// Moves on by one step.
  void step();

  double timeSeconds() const;  ///< since the start
  Stamp now() const;
  const Pose2& worldFromBase() const { return world_from_base_; }
  Pose2 worldFromSensor() const { return world_from_base_ * config_.base_from_sensor; }
  const std::vector<Light>& lights() const { return lights_; }
  bool bearingsDue() const { return steps_ % config_.steps_per_bearing == 0; }
  bool lightsOccluded() const;

  /// The counters, when a reading is due now and not lost.
  std::optional<WheelCounts> readTicks() const;
  /// Noisy bearings, when they are due now. Call at most once in a step.
  std::optional<BearingSet> readBearings();

 private:
  WheelDisplacement turned(const WheelDisplacement& ground) const;

  RobotConfig config_;
  std::vector<Light> lights_;
  Trajectory trajectory_;
  WheelEncoders encoders_;
  BearingSensor sensor_;
  double wheel_separation_m_;  ///< the true one
  Duration step_;
  Pose2 world_from_base_;
  std::int64_t steps_ = 0;
};

/// Everything that happened in one run. `bearings` and `world_from_base` go together.
struct SimulatedRecord {
  std::vector<WheelCounts> ticks;
  std::vector<BearingSet> bearings;
  std::vector<Pose2> world_from_base;  ///< true pose at each of `bearings`
};

/// Runs the simulator for `duration_s`, its present moment included.
SimulatedRecord record(RobotSimulator* simulator, double duration_s);

}  // namespace bearing_calibration::core
