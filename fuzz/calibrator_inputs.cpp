// What the calibrator of a CalibratorFuzzer is told, and what must be true after it.

#include <algorithm>
#include <chrono>
#include <numeric>

#include "bearing_calibration/simulation/robot_sensors.h"
#include "fuzz/calibrator_fuzzer.h"
#include "fuzz/harness.h"
#include "fuzz/result_checks.h"

namespace bearing_calibration::fuzz {

void CalibratorFuzzer::addReading(core::Stamp stamp, Reading reading) {
  const core::Stamp received = world_.now();
  reading.ticks.stamp = reading.angles.stamp = reading.odometry.stamp = stamp;
  switch (source_) {
    case Source::kTicks:
      calibrator_->addTicks(reading.ticks, received);
      break;
    case Source::kAngles:
      calibrator_->addAngles(reading.angles, received);
      break;
    case Source::kSeparate:  // read one after the other
      calibrator_->addWheel(core::WheelSide::kRight,
                            {stamp - std::chrono::milliseconds(10), reading.ticks.right_ticks},
                            received);
      calibrator_->addWheel(core::WheelSide::kLeft, {stamp, reading.ticks.left_ticks}, received);
      break;
    case Source::kOdometry:
      calibrator_->addOdometry(reading.odometry, received);
      break;
  }
  ++readings_;
}

void CalibratorFuzzer::sendWheels() {
  if (channel_.loses_wheels) return;
  const int bits = config_.drive.counter_bits;
  const auto counted = [bits](std::int64_t ticks, std::int64_t offset) {
    const auto sum = static_cast<std::uint64_t>(ticks) + static_cast<std::uint64_t>(offset);
    return core::wrapCounter(static_cast<std::int64_t>(sum), bits, true);
  };
  Reading reading;
  reading.ticks.left_ticks = counted(world_.leftTicks(), channel_.left_offset);
  reading.ticks.right_ticks = counted(world_.rightTicks(), channel_.right_offset);
  reading.angles.left_rad = world_.leftAngle();
  reading.angles.right_rad = world_.rightAngle();
  reading.odometry.start_from_base = world_.worldFromBase();
  addReading(world_.now() - channel_.wheels_late, reading);
}

void CalibratorFuzzer::sendBearings() {
  if (images_ >= most_images_) return;
  ++images_;
  if (channel_.loses_bearings) return;
  core::BearingSet set{world_.now() - channel_.bearings_late, world_.bearings(channel_.stddev_rad),
                       channel_.geometry};
  spoil(&set.candidates);
  calibrator_->addBearings(set, world_.now());
}

void CalibratorFuzzer::sendOddWheels() {
  const core::Stamp stamp = anyStamp();
  Reading reading;
  reading.ticks.left_ticks = static_cast<std::int64_t>(bytes_.bits());
  reading.ticks.right_ticks = static_cast<std::int64_t>(bytes_.bits());
  reading.angles.left_rad = bytes_.anyNumber();
  reading.angles.right_rad = bytes_.anyNumber();
  if (source_ == Source::kOdometry) {
    reading.odometry.start_from_base = {{reading.angles.left_rad, reading.angles.right_rad},
                                        bytes_.anyNumber()};
    reading.odometry.forward_mps = bytes_.anyNumber();
    if (bytes_.flag()) reading.odometry.quaternion_norm = bytes_.anyNumber();
    if (bytes_.flag()) reading.odometry.frames = "others";
  }
  addReading(stamp, reading);
}

void CalibratorFuzzer::sendOddBearings() {
  core::BearingSet set{anyStamp(), world_.bearings(channel_.stddev_rad), channel_.geometry};
  const std::uint8_t flaw = channel_.flaw;
  constexpr std::uint8_t kAddsAnOddOne = 128;
  channel_.flaw = static_cast<std::uint8_t>(bytes_.byte() | kAddsAnOddOne);
  for (int i = bytes_.byte() % 8; i >= 0; --i) spoil(&set.candidates);
  channel_.flaw = flaw;
  ++images_;
  calibrator_->addBearings(set, world_.now());
}

/// Any that ros::Time holds: near to now, or far.
core::Stamp CalibratorFuzzer::anyStamp() {
  static constexpr std::int64_t kFar_ns[] = {0, 1, 1000000000, 4294967295999999999};
  if (bytes_.flag()) return core::stampFromNanoseconds(bytes_.pick(kFar_ns));
  return world_.now() + core::durationFromSeconds(bytes_.between(-2.0, 2.0));
}

void CalibratorFuzzer::restart() {
  calibrator_->reset();
  readings_ = 0;
  const core::CalibrationResult result = calibrator_->result();
  const auto expected =
      paused_ ? core::CalibrationState::kPaused : core::CalibrationState::kWaitingForTicks;
  require(result.state == expected && !result.base_from_sensor && result.ticks_used == 0 &&
              result.distance_travelled_m == 0.0,
          "something is left after a reset");
}

/// Another calibrator, that goes on from what this one has saved.
void CalibratorFuzzer::resume() {
  const core::CalibrationResult result = calibrator_->result();
  if (!result.base_from_sensor || !core::mayBeTrusted(result.state)) return;
  const core::ResultFileContent content = readBack(core::resultText(saved(result)));
  require(content.calibration.has_value(), "a written result is refused: " + content.error);
  calibrator_ = std::make_unique<core::Calibrator>(config_);
  calibrator_->resume(content.calibration->lasting);
  paused_ = false;
  readings_ = 0;
}

void CalibratorFuzzer::check() {
  const core::CalibrationResult result = calibrator_->result();
  requireMeaning(result);
  require((result.state == core::CalibrationState::kPaused) == paused_, "paused, or not");
  require(result.bearings_waiting <= static_cast<std::uint32_t>(config_.bearings.max_waiting),
          "more bearings wait than may");
  const auto& counts = result.tick_inputs.by_status;
  require(source_ == Source::kSeparate ||
              std::accumulate(counts.begin(), counts.end(), 0U) == readings_,
          "a wheel reading is not counted");
  require(result.ticks_used <= readings_, "more wheel readings are used than came");
  if (const auto place = calibrator_->place()) {
    require(place->start_from_base.position_m.allFinite(), "the place of the base is none");
  }
}

}  // namespace bearing_calibration::fuzz
