#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/simulation/random_stream.h"

namespace bearing_calibration::core {

/// How the wheels of a robot roll over the ground, one step after the other.
class Trajectory {
 public:
  virtual ~Trajectory() = default;

  /// What each wheel rolls during the next `step_s` > 0 seconds.
  virtual WheelDisplacement advance(double step_s) = 0;
};

/// A piece of constant wheel speeds.
struct DriveSegment {
  double left_mps = 0.0;
  double right_mps = 0.0;
  double duration_s = 0.0;
};

/// Segments driven one after the other, over and over.
class SegmentTrajectory final : public Trajectory {
 public:
  /// @throws std::invalid_argument without a segment, or when one does not last.
  explicit SegmentTrajectory(std::vector<DriveSegment> segments);
  WheelDisplacement advance(double step_s) override;

 private:
  std::vector<DriveSegment> segments_;
  std::size_t current_ = 0;
  double left_in_segment_s_ = 0.0;  ///< what remains of the current segment
};

/// Constant speed of the base's centre with a heading that swings like a sine.
class SinusoidTrajectory final : public Trajectory {
 public:
  struct Config {
    double speed_mps = 0.0;      ///< of the base's centre
    double amplitude_rad = 0.0;  ///< of the heading
    double period_s = 0.0;
  };
  SinusoidTrajectory(const Config& config, double wheel_separation_m);
  WheelDisplacement advance(double step_s) override;

 private:
  Config config_;
  double wheel_separation_m_;
  double time_s_ = 0.0;
};

/// The paper's first trajectory (section V-A): in each step each wheel rolls a Gaussian distance of
/// mean v dt and variance k v dt; the paper's k is 0.01 m.
class RandomTrajectory final : public Trajectory {
 public:
  RandomTrajectory(double wheel_speed_mps, double variance_per_meter_m, std::uint64_t seed);
  WheelDisplacement advance(double step_s) override;

 private:
  double wheel_speed_mps_;
  double variance_per_meter_m_;
  RandomStream random_;
};

/// Follows velocity commands; stands still when none came for `timeout_s`.
class CommandedTrajectory final : public Trajectory {
 public:
  CommandedTrajectory(double wheel_separation_m, double max_wheel_speed_mps, double timeout_s);

  /// The velocity of the base from now on; slowed down, with its curvature kept, when a wheel would
  /// be faster than it can.
  void command(double forward_mps, double turn_radps);
  WheelDisplacement advance(double step_s) override;

 private:
  double wheel_separation_m_;
  double max_wheel_speed_mps_;
  double timeout_s_;
  DriveSegment command_;  ///< its duration is what remains before the time-out
};

/// Another trajectory for a while, standing still for ever after.
class LimitedTrajectory final : public Trajectory {
 public:
  LimitedTrajectory(std::unique_ptr<Trajectory> trajectory, double duration_s);
  WheelDisplacement advance(double step_s) override;

 private:
  std::unique_ptr<Trajectory> trajectory_;
  double left_s_;
};

}  // namespace bearing_calibration::core
