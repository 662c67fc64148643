#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// What an image sensor makes of light.
struct PixelConfig {
  double full_well_electrons = 12000.0;
  double read_noise_electrons = 12.0;

  void declare(Parameters& params);
};

/// Photon (shot) noise and read noise, both Gaussian, then saturation and 8 bits.
class PixelNoise {
 public:
  static constexpr double kLargestValue = 255.0;

  /// @throws std::invalid_argument with what errorsOf() says.
  PixelNoise(const PixelConfig& config, std::uint64_t seed);

  /// `electrons`: expected photo-electrons of each pixel. The same seed and number give the same
  /// noise.
  void digitize(const std::vector<float>& electrons, std::uint64_t image_number,
                std::vector<std::uint8_t>* values) const;

 private:
  PixelConfig config_;
  std::uint64_t seed_;
  std::vector<float> quantiles_;  ///< equally likely values of a standard Gaussian
};

}  // namespace bearing_calibration::core
