#include "fuzz/drawn_config.h"

#include <algorithm>
#include <stdexcept>
#include <variant>

#include "bearing_calibration/calibration/calibrator.h"
#include "fuzz/harness.h"
#include "tools/study/default_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::fuzz {
namespace {

/// Changes a few of the numbers that are declared to it, and reads them so.
class ChangedParameters : public core::Parameters {
 public:
  explicit ChangedParameters(ByteReader* bytes) : bytes_(bytes) { skip(); }

 private:
  /// So many parameters stay as they are before the next one changes.
  void skip() { skip_ = changes_++ < kMostChanges ? bytes_->byte() : kAll; }

  bool readInto(const std::string& /*name*/, const Target& target) override {
    if (skip_-- != 0) return false;
    skip();
    static constexpr double kFactors[] = {0.0, 1e-6, 0.01, 0.1, 0.5, 2.0, 10.0, 100.0, 1e6, -1.0};
    const double factor = bytes_->pick(kFactors);
    if (auto* const* number = std::get_if<double*>(&target)) {
      **number = **number == 0.0 ? 0.01 * factor : **number * factor;
    } else if (auto* const* whole = std::get_if<int*>(&target)) {
      constexpr double kLargest = 1e9;  // of an int
      **whole = static_cast<int>(std::min(**whole * factor, kLargest));
    } else if (auto* const* flag = std::get_if<bool*>(&target)) {
      **flag = !**flag;
    } else {
      return false;
    }
    return true;
  }

  static constexpr int kMostChanges = 6;
  static constexpr int kAll = 1 << 20;
  ByteReader* bytes_;
  int changes_ = 0;
  int skip_ = 0;
};

core::CalibratorConfig shippedConfig() {
  core::CalibratorConfig config =
      core::defaultCalibration({0.25, 0.05, 0.05, 65536.0, 32, 2.0}, {1e-6, 0.0});
  config.initializer.batch.errors = core::usualErrors();
  config.initializer.noise = core::usualNoise();
  return config;
}

}  // namespace

core::CalibratorConfig drawConfig(ByteReader* bytes) {
  static constexpr int kLights[] = {1, 1, 2, 4};
  static constexpr int kCounterBits[] = {32, 64, 16};
  static constexpr std::size_t kCapacities[] = {1200, 200, 100};
  core::CalibratorConfig config = shippedConfig();
  const std::uint8_t kind = bytes->byte();
  config.max_lights = kLights[kind & 3U];
  config.drive.counter_bits = kCounterBits[(kind >> 2U & 3U) % std::size(kCounterBits)];
  config.initializer.record.capacity = kCapacities[(kind >> 4U & 3U) % std::size(kCapacities)];
  if ((kind & 64U) != 0) {  // as config/paper.yaml
    config.filter.parametrisation = core::FilterConfig::Parametrisation::kPaper;
    config.initializer.batch.errors = {};
    config.initializer.noise = {};
  }
  if ((kind & 128U) == 0) return config;
  core::CalibratorConfig changed = config;
  ChangedParameters params(bytes);
  changed.declare(params);
  if (core::errorsOf(changed).empty()) return changed;
  try {
    core::Calibrator calibrator(changed);
    require(false, "a configuration with errors is taken");
  } catch (const std::invalid_argument&) {
  }
  return config;
}

}  // namespace bearing_calibration::fuzz
