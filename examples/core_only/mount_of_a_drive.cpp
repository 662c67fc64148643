// Finds a bearing sensor's mount with the core library alone: no ROS, no files. The readings are
// those of a simulated drive; put your robot's in their place.

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/calibration/shipped_calibration.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/geometry/pose2.h"

namespace {

namespace core = bearing_calibration::core;

/// Of your robot: separation [m], radii [m], ticks per revolution, counter's bits, largest speed
/// [m/s].
constexpr core::DriveGeometry kWheels{0.40, 0.0975, 0.0975, 2048.0, 32, 2.0};
constexpr double kBearingStddev_rad = 0.01;

/// Drives a metre straight, turns by 450 degrees on the spot, and so on, past a light at the
/// origin.
class SimulatedDrive {
 public:
  void step() {
    constexpr double kWay_m = 0.2 / kReadings_hz;  // of the faster wheel
    constexpr int kStraight = 5 * kReadings_hz;
    const int spin = static_cast<int>(2.5 * core::kPi * 0.5 * kWheels.wheel_separation_m / kWay_m);
    const bool turns = readings_++ % (kStraight + spin) >= kStraight;
    const double left_m = turns ? -kWay_m : kWay_m;
    left_m_ += left_m;
    right_m_ += kWay_m;
    const double turn_rad = (kWay_m - left_m) / kWheels.wheel_separation_m;
    const double ahead_m = 0.5 * (kWay_m + left_m);
    world_from_base_ = world_from_base_ * core::Pose2{{ahead_m, 0.0}, turn_rad};
  }

  core::WheelCounts ticks() const {
    return {now(), std::llround(left_m_ / kWheels.leftMetersPerTick()),
            std::llround(right_m_ / kWheels.rightMetersPerTick())};
  }

  core::BearingSet bearings() {
    const core::Pose2 world_from_sensor = world_from_base_ * base_from_sensor;
    const Eigen::Vector2d light_m = world_from_sensor.inverse() * Eigen::Vector2d::Zero();
    core::Bearing bearing;
    bearing.azimuth_rad = std::atan2(light_m.y(), light_m.x()) + noise_(random_);
    bearing.azimuth_variance_rad2 = kBearingStddev_rad * kBearingStddev_rad;
    return {now(), {bearing}};
  }

  core::Stamp now() const { return core::stampFromSeconds(1.0 + readings_ / double{kReadings_hz}); }

  static constexpr int kReadings_hz = 50;
  core::Pose2 base_from_sensor{{0.15, 0.08}, 0.2};  // what is to be found

 private:
  core::Pose2 world_from_base_{{-0.5, 1.0}, 0.0};
  double left_m_ = 0.0;
  double right_m_ = 0.0;
  int readings_ = 0;
  std::mt19937 random_{1};
  std::normal_distribution<double> noise_{0.0, kBearingStddev_rad};
};

void print(const core::CalibrationResult& result, const core::Pose2& truth) {
  std::printf("%s: %s\n", core::nameOf(result.state), result.advice.c_str());
  if (!result.base_from_sensor) return;
  const Eigen::Vector3d& mean = result.base_from_sensor->mean;
  const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
  std::printf("x   %8.4f +- %.4f m    (true %.4f)\n", mean.x(), stddev.x(), truth.position_m.x());
  std::printf("y   %8.4f +- %.4f m    (true %.4f)\n", mean.y(), stddev.y(), truth.position_m.y());
  std::printf("yaw %8.4f +- %.4f rad  (true %.4f)\n", mean.z(), stddev.z(), truth.yaw_rad);
}

}  // namespace

int main() {
  constexpr int kReadings = 120 * SimulatedDrive::kReadings_hz;
  constexpr int kReadingsPerBearing = 5;
  core::Calibrator calibrator(core::shippedCalibration(kWheels));
  SimulatedDrive drive;
  for (int i = 0; i < kReadings; ++i) {
    calibrator.addTicks(drive.ticks(), drive.now());
    if (i % kReadingsPerBearing == 0) calibrator.addBearings(drive.bearings(), drive.now());
    drive.step();
  }
  const core::CalibrationResult result = calibrator.result();
  print(result, drive.base_from_sensor);
  return result.state == core::CalibrationState::kConverged ? 0 : 1;
}
