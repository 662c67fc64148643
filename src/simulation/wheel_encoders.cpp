#include "bearing_calibration/simulation/wheel_encoders.h"

#include <cmath>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

constexpr int kWordBits = 64;  // of the counts themselves

}  // namespace

std::int64_t wrapCounter(std::int64_t count, int bits, bool is_signed) {
  if (bits >= kWordBits) return count;
  const std::uint64_t period = std::uint64_t{1} << bits;
  const std::uint64_t low = static_cast<std::uint64_t>(count) & (period - 1);
  const bool is_negative = is_signed && low >= period / 2;
  return static_cast<std::int64_t>(is_negative ? low - period : low);
}

void EncoderConfig::declare(Parameters& params) {
  using plausible::kLargestRatio;
  drive.declare(params);
  params.read("wheels/signed_counters", signed_counters);
  for (auto [name, ticks] : {std::pair("wheels/left_start", &left_start_ticks),
                             std::pair("wheels/right_start", &right_start_ticks)}) {
    int start = 0;
    if (params.read(name, start)) *ticks = start;
  }
  noise.declareLevels(params);
  params.number("faults/left_radius_factor", left_radius_factor, 1.0 / kLargestRatio,
                kLargestRatio);
  params.number("faults/right_radius_factor", right_radius_factor, 1.0 / kLargestRatio,
                kLargestRatio);
}

WheelEncoders::WheelEncoders(const EncoderConfig& config, std::uint64_t seed)
    : config_(validated(config)), random_(seed, RandomStream::Purpose::kEncoders) {
  left_ = {0.0, config.drive.leftMetersPerTick() * config.left_radius_factor,
           config.left_start_ticks};
  right_ = {0.0, config.drive.rightMetersPerTick() * config.right_radius_factor,
            config.right_start_ticks};
}

void WheelEncoders::roll(const WheelDisplacement& turned) {
  const WheelNoise& noise = config_.noise;
  const auto own_error = [&](double displacement_m) {
    return std::sqrt(noise.independent_k_m * std::abs(displacement_m)) * random_.gaussian();
  };
  left_.reported_m += turned.left_m + own_error(turned.left_m);
  right_.reported_m += turned.right_m + own_error(turned.right_m);
  if (noise.common_k_m > 0.0) {
    const double distance_m = 0.5 * std::abs(turned.left_m + turned.right_m);
    const double shared_error_m = std::sqrt(noise.common_k_m * distance_m) * random_.gaussian();
    left_.reported_m += shared_error_m;
    right_.reported_m += shared_error_m;
  }
}

std::int64_t WheelEncoders::count(const Wheel& wheel) const {
  const double ticks = std::floor(wheel.reported_m / wheel.meters_per_tick);
  return wrapCounter(wheel.start_ticks + static_cast<std::int64_t>(ticks),
                     config_.drive.counter_bits, config_.signed_counters);
}

WheelCounts WheelEncoders::read(Stamp stamp) const { return {stamp, count(left_), count(right_)}; }

void WheelEncoders::resetCounters() {
  for (Wheel* wheel : {&left_, &right_}) {
    wheel->reported_m = 0.0;
    wheel->start_ticks = 0;
  }
}

}  // namespace bearing_calibration::core
