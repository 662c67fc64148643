#include "fuzz/calibrator_fuzzer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "fuzz/drawn_config.h"
#include "fuzz/harness.h"
#include "fuzz/result_checks.h"

namespace bearing_calibration::fuzz {
namespace {

constexpr double kSpeed_mps = 0.3;
constexpr core::Duration kReadingPeriod = std::chrono::milliseconds(50);
constexpr int kReadingsPerImage = 4;

/// Of a clock, or of silence: from a nanosecond to a year.
core::Duration drawDuration(ByteReader* bytes) {
  static constexpr double kSizes_s[] = {0.0, 1e-9, 1e-3, 0.05, 0.1, 0.5, 2.0, 15.0, 4e3, 3.2e7};
  const double size_s = bytes->pick(kSizes_s);
  return core::durationFromSeconds(bytes->flag() ? -size_s : size_s);
}

core::Bearing oddBearing(ByteReader* bytes) {
  static constexpr std::int32_t kIds[] = {
      core::kUnknownLight, 0, 1, 7, -2, std::numeric_limits<std::int32_t>::max()};
  core::Bearing bearing;
  bearing.azimuth_rad = bytes->flag() ? bytes->anyNumber() : bytes->between(-core::kPi, core::kPi);
  bearing.azimuth_variance_rad2 = bytes->flag() ? bytes->anyNumber() : 1e-4;
  if (bytes->flag()) {
    bearing.elevation_rad = bytes->anyNumber();
    bearing.elevation_variance_rad2 = bytes->anyNumber();
  }
  bearing.light_id = bytes->pick(kIds);
  bearing.probability = bytes->flag() ? bytes->anyNumber() : 1.0;
  return bearing;
}

}  // namespace

CalibratorFuzzer::CalibratorFuzzer(ByteReader* bytes)
    : bytes_(*bytes),
      config_(drawConfig(bytes)),
      calibrator_(std::make_unique<core::Calibrator>(config_)),
      world_(config_.drive, bytes->byte()) {
  const std::uint8_t kind = bytes->byte();
  constexpr std::uint8_t kSources = 4;
  constexpr std::uint8_t kLong = 224;  // and above, of 255
  source_ = static_cast<Source>(kind % kSources);
  most_images_ = kind >= kLong ? kImagesOfLong : kImagesOfShort;
}

bool CalibratorFuzzer::step() {
  if (images_ >= most_images_) return false;
  if (bytes_.isEmpty()) {
    driveToCalibrate();
  } else {
    doWhatBytesSay();
  }
  check();
  return true;
}

void CalibratorFuzzer::doWhatBytesSay() {
  constexpr int kEvents = 14;
  const double separation_m = config_.drive.wheel_separation_m;
  switch (bytes_.byte() % kEvents) {
    case 0: {  // to both sides straight
      const double way_m = bytes_.between(-2.0, 2.0);
      drive(way_m, way_m);
      break;
    }
    case 1: {  // on the spot
      const double turn_rad = bytes_.between(-2.0 * core::kPi, 2.0 * core::kPi);
      drive(-0.5 * separation_m * turn_rad, 0.5 * separation_m * turn_rad);
      break;
    }
    case 2: {
      const double left_m = bytes_.between(-2.0, 2.0);
      drive(left_m, bytes_.between(-2.0, 2.0));
      break;
    }
    case 3:
      for (int times = bytes_.byte() % 8; times >= 0; --times) driveToCalibrate();
      break;
    case 4:
      world_.wait(std::max(core::Duration{}, drawDuration(&bytes_)));
      break;
    case 5:
      setChannel();
      break;
    case 6:
      changeWorld();
      break;
    case 7:
      sendOddWheels();
      break;
    case 8:
      sendOddBearings();
      break;
    case 9:
      paused_ = bytes_.flag();
      calibrator_->setPaused(paused_);
      break;
    case 10:
      restart();
      break;
    case 11:
      resume();
      break;
    case 12:  // stands, and looks on
      for (int images = bytes_.byte(); images > 0; --images) wait(std::chrono::milliseconds(200));
      break;
    default:
      if (const auto prediction = calibrator_->predictBearing(anyStamp())) {
        require(std::isfinite(prediction->azimuth_rad) &&
                    std::isfinite(prediction->azimuth_variance_rad2) &&
                    prediction->azimuth_variance_rad2 >= 0.0,
                "a prediction is no bearing");
      }
  }
}

void CalibratorFuzzer::driveToCalibrate() {
  drive(1.0, 1.0);
  const double turn_m = 0.5 * config_.drive.wheel_separation_m * 2.5 * core::kPi;
  drive(-turn_m, turn_m);
}

void CalibratorFuzzer::drive(double left_m, double right_m) {
  const double longest_m = std::max(std::abs(left_m), std::abs(right_m));
  constexpr double kMostSteps = 400;  // of a robot that is metres wide
  const double steps =
      std::ceil(longest_m / (kSpeed_mps * core::secondsFromDuration(kReadingPeriod)));
  const int whole = static_cast<int>(std::min(kMostSteps, steps));
  for (int i = 0; i < whole; ++i) {
    world_.roll({left_m / whole, right_m / whole}, kReadingPeriod);
    sendWheels();
    if (i % kReadingsPerImage == 0) sendBearings();
  }
}

void CalibratorFuzzer::wait(core::Duration time) {
  world_.wait(time);
  sendWheels();
  sendBearings();
}

void CalibratorFuzzer::setChannel() {
  constexpr int kKinds = 8;
  switch (bytes_.byte() % kKinds) {
    case 0:
      channel_.wheels_late = drawDuration(&bytes_);
      break;
    case 1:
      channel_.bearings_late = drawDuration(&bytes_);
      break;
    case 2:
      channel_.left_offset = static_cast<std::int64_t>(bytes_.bits());
      channel_.right_offset = bytes_.flag() ? channel_.left_offset : 0;
      break;
    case 3:
      channel_.loses_wheels = bytes_.flag();
      break;
    case 4:
      channel_.loses_bearings = bytes_.flag();
      break;
    case 5:
      channel_.flaw = bytes_.byte();
      break;
    case 6:
      channel_.stddev_rad = std::pow(10.0, bytes_.between(-6.0, -0.5));
      break;
    default:
      channel_.geometry = {bytes_.finiteNumber(), bytes_.finiteNumber(), bytes_.finiteNumber()};
  }
}

void CalibratorFuzzer::changeWorld() {
  const Eigen::Vector2d by{bytes_.between(-2.0, 2.0), bytes_.between(-2.0, 2.0)};
  if (bytes_.flag()) {
    world_.displaceMount({0.1 * by, bytes_.between(-core::kPi, core::kPi)});
  } else {
    world_.moveLight(bytes_.byte(), by);
  }
}

void CalibratorFuzzer::spoil(std::vector<core::Bearing>* bearings) {
  const std::uint8_t flaw = channel_.flaw;
  if ((flaw & 1U) == 0) bearings->resize(1);
  for (core::Bearing& bearing : *bearings) {
    if ((flaw & 2U) != 0) bearing.light_id = core::kUnknownLight;
    if ((flaw & 4U) != 0) bearing.azimuth_rad *= -1.0;
    if ((flaw & 8U) != 0) bearing.azimuth_variance_rad2 *= 1e-4;
    if ((flaw & 16U) != 0) {
      bearing.elevation_rad = 0.1;
      bearing.elevation_variance_rad2 = 1e-4;
    }
    if ((flaw & 32U) != 0) bearing.azimuth_rad = bytes_.between(-core::kPi, core::kPi);
  }
  if ((flaw & 64U) != 0) std::reverse(bearings->begin(), bearings->end());
  if ((flaw & 128U) != 0) bearings->push_back(oddBearing(&bytes_));
}

bool CalibratorFuzzer::finish() {
  const core::CalibrationResult result = calibrator_->result();
  if (!result.base_from_sensor) return false;
  requireRoundTrip(saved(result));
  return true;
}

core::SavedCalibration CalibratorFuzzer::saved(const core::CalibrationResult& result) const {
  core::SavedCalibration saved;
  saved.result = result;
  saved.base_frame = "base_link";
  saved.sensor_frame = "camera";
  saved.lasting = core::lastingPart(*result.estimate);
  saved.unestimated = {0.1, 0.01, 0.0, 0.01, 0.0, 0.01};
  saved.provenance.drive = config_.drive;
  return saved;
}

bool run(const std::uint8_t* data, std::size_t size) {
  ByteReader bytes(data, size);
  CalibratorFuzzer fuzzer(&bytes);
  bool goes_on = true;
  while (goes_on) goes_on = fuzzer.step();
  return fuzzer.finish();
}

}  // namespace bearing_calibration::fuzz
