#pragma once

#include <memory>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/output/result_file.h"
#include "fuzz/byte_reader.h"
#include "fuzz/simulated_world.h"

namespace bearing_calibration::fuzz {

/// A calibrator with a robot that drives about, whose messages are sound for a while and broken for
/// another, as the bytes say. What must hold of a result is checked after each event.
class CalibratorFuzzer {
 public:
  explicit CalibratorFuzzer(ByteReader* bytes);

  /// Goes on, with what the bytes say, and after their end as a calibration is driven.
  /// @return false when all of its images have come
  /// @throws std::logic_error when something that must hold does not
  bool step();
  /// Writes the last result, and reads it back. @return whether there was one
  bool finish();

 private:
  // With four wheel readings to an image: 750 messages and 200. CONVERGED takes 136 images.
  static constexpr int kImagesOfLong = 150;
  static constexpr int kImagesOfShort = 40;

  /// What comes between the robot and the calibrator.
  struct Channel {
    core::Duration wheels_late{};
    core::Duration bearings_late{};
    std::int64_t left_offset = 0;
    std::int64_t right_offset = 0;
    bool loses_wheels = false;
    bool loses_bearings = false;
    std::uint8_t flaw = 0;     ///< of bearings, see spoil()
    double stddev_rad = 0.01;  ///< of bearings
    core::SensorGeometry geometry;
  };

  void doWhatBytesSay();
  void drive(double left_m, double right_m);
  void driveToCalibrate();
  void wait(core::Duration time);
  void setChannel();
  void changeWorld();
  void sendWheels();
  void sendBearings();
  void sendOddWheels();
  void sendOddBearings();
  void spoil(std::vector<core::Bearing>* bearings);
  void resume();
  void restart();
  void check();
  core::Stamp anyStamp();
  /// What the wheels say, in the way of each source.
  struct Reading {
    core::WheelCounts ticks;
    core::WheelAngles angles;
    core::OdometryPose odometry;
  };
  void addReading(core::Stamp stamp, Reading reading);
  core::SavedCalibration saved(const core::CalibrationResult& result) const;

  ByteReader& bytes_;
  core::CalibratorConfig config_;
  std::unique_ptr<core::Calibrator> calibrator_;
  SimulatedWorld world_;
  enum class Source : std::uint8_t { kTicks, kAngles, kSeparate, kOdometry };
  Source source_{};
  Channel channel_;
  int images_ = 0;
  int most_images_ = 0;
  bool paused_ = false;
  std::uint32_t readings_ = 0;  ///< since the last start
};

}  // namespace bearing_calibration::fuzz
