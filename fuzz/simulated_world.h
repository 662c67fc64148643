#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "bearing_calibration/geometry/pose2.h"
#include "bearing_calibration/odometry/drive_geometry.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::fuzz {

/// A robot with a bearing sensor between some lights, all of which may be moved at any moment. Its
/// counters are exact but for whole ticks; bearings have noise.
class SimulatedWorld {
 public:
  SimulatedWorld(const core::DriveGeometry& drive, std::uint32_t seed);

  void roll(const core::WheelDisplacement& wheels, core::Duration time);
  void wait(core::Duration time) { now_ += time; }
  core::Stamp now() const { return now_; }
  const core::Pose2& worldFromBase() const { return world_from_base_; }

  std::int64_t leftTicks() const;   ///< cumulative, of any size
  std::int64_t rightTicks() const;  ///< the same
  double leftAngle() const { return left_m_ / drive_.left_wheel_radius_m; }
  double rightAngle() const { return right_m_ / drive_.right_wheel_radius_m; }
  /// Of each light, numbered.
  std::vector<core::Bearing> bearings(double stddev_rad);

  void displaceMount(const core::Pose2& by) { base_from_sensor_ = base_from_sensor_ * by; }
  void moveLight(std::size_t light, const Eigen::Vector2d& to) {
    lights_m_[light % lights_m_.size()] = to;
  }

 private:
  core::DriveGeometry drive_;
  core::Stamp now_ = core::stampFromSeconds(1000.0);
  core::Pose2 world_from_base_;
  core::Pose2 base_from_sensor_{{0.1, 0.05}, 1.0};
  std::vector<Eigen::Vector2d> lights_m_ = {{1.5, 0.5}, {-1.0, 2.0}, {0.5, -2.0}};
  double left_m_ = 0.0;
  double right_m_ = 0.0;
  std::mt19937 random_;
  std::normal_distribution<double> gaussian_;
};

}  // namespace bearing_calibration::fuzz
