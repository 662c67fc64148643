#include "bearing_calibration/simulation/pixel_noise.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

constexpr unsigned kQuantileBits = 16;  // four draws from one 64-bit word; up to 4.3 sigma
constexpr std::size_t kQuantileCount = std::size_t{1} << kQuantileBits;
constexpr std::uint64_t kQuantileMask = kQuantileCount - 1;
constexpr std::size_t kDrawsPerWord = 64 / kQuantileBits;

// SplitMix64 (Steele, Lea, Flood 2014): the golden ratio's step and a mixing of the bits.
constexpr std::uint64_t kGoldenStep = 0x9E3779B97F4A7C15ULL;

std::uint64_t mixBits(std::uint64_t z) {
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
  return z ^ (z >> 31U);
}

/// Midpoints of equally likely classes of a standard Gaussian, scaled to variance 1.
std::vector<float> gaussianQuantiles() {
  const boost::math::normal standard;
  std::vector<double> upper(kQuantileCount / 2);
  double square_sum = 0.0;
  for (std::size_t i = 0; i < upper.size(); ++i) {
    const double probability =
        0.5 + (static_cast<double>(i) + 0.5) / static_cast<double>(kQuantileCount);
    upper[i] = boost::math::quantile(standard, probability);
    square_sum += upper[i] * upper[i];
  }
  const double scale = 1.0 / std::sqrt(square_sum / static_cast<double>(upper.size()));
  std::vector<float> quantiles;
  quantiles.reserve(kQuantileCount);
  for (double value : upper) {
    quantiles.push_back(static_cast<float>(scale * value));
    quantiles.push_back(static_cast<float>(-scale * value));
  }
  return quantiles;
}

}  // namespace

void PixelConfig::declare(Parameters& params) {
  constexpr double kMostElectrons = 1e9;
  params.number("camera/full_well", full_well_electrons, 1.0, kMostElectrons);
  params.number("camera/read_noise", read_noise_electrons, 0.0, kMostElectrons);
}

PixelNoise::PixelNoise(const PixelConfig& config, std::uint64_t seed)
    : config_(validated(config)), seed_(seed), quantiles_(gaussianQuantiles()) {}

void PixelNoise::digitize(const std::vector<float>& electrons, std::uint64_t image_number,
                          std::vector<std::uint8_t>* values) const {
  const float read_variance =
      static_cast<float>(config_.read_noise_electrons * config_.read_noise_electrons);
  const float largest = static_cast<float>(kLargestValue);
  const float values_per_electron = largest / static_cast<float>(config_.full_well_electrons);
  std::uint64_t state = mixBits(mixBits(seed_) + kGoldenStep * image_number);
  values->resize(electrons.size());
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < electrons.size(); ++i) {
    if (i % kDrawsPerWord == 0) word = mixBits(state += kGoldenStep);
    const float gaussian = quantiles_[word & kQuantileMask];
    word >>= kQuantileBits;
    const float noisy = electrons[i] + std::sqrt(electrons[i] + read_variance) * gaussian;
    const float value = std::clamp(noisy * values_per_electron, 0.0F, largest);
    (*values)[i] = static_cast<std::uint8_t>(value + 0.5F);
  }
}

}  // namespace bearing_calibration::core
