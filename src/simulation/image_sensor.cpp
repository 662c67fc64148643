#include "bearing_calibration/simulation/image_sensor.h"

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <cstddef>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace bearing_calibration::core {
namespace {

using Layout = ImageEncoding::Layout;

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

bool isMosaic(Layout layout) { return layout != Layout::kMono8 && layout != Layout::kBgr8; }

}  // namespace

void Shutter::declare(Parameters& params) {
  constexpr double kLongestExposure_s = 1.0;
  constexpr double kLongestRow_s = 1e-3;  // a second for a thousand rows
  params.number("camera/exposure_time", exposure_s, 0.0, kLongestExposure_s);
  params.number("camera/row_time", row_time_s, 0.0, kLongestRow_s);
}

// The way points along the mean heading of its time, which is right to the second order.
Pose2 SensorMotion::poseAt(double time_s) const {
  if (time_s == 0.0) return world_from_sensor;
  const double turn_rad = turn_radps * time_s;
  return world_from_sensor * Pose2{rotation2(0.5 * turn_rad) * velocity_mps * time_s, turn_rad};
}

SensorMotion motionBetween(const Pose2& world_from_start, const Pose2& world_from_end,
                           double duration_s) {
  const Pose2 start_from_end = world_from_start.inverse() * world_from_end;
  const double turn_rad = start_from_end.yaw_rad;
  return {world_from_start, rotation2(-0.5 * turn_rad) * start_from_end.position_m / duration_s,
          turn_rad / duration_s};
}

void PixelConfig::declare(Parameters& params) {
  constexpr double kMostElectrons = 1e9;
  params.number("camera/full_well", full_well_electrons, 1.0, kMostElectrons);
  params.number("camera/read_noise", read_noise_electrons, 0.0, kMostElectrons);
}

std::vector<std::uint8_t> digitize(const std::vector<float>& electrons, const PixelConfig& pixels,
                                   std::uint64_t seed, std::uint64_t image_number) {
  static const std::vector<float> quantiles = gaussianQuantiles();
  const float read_variance =
      static_cast<float>(pixels.read_noise_electrons * pixels.read_noise_electrons);
  const float largest = static_cast<float>(PixelConfig::kLargestValue);
  const float values_per_electron = largest / static_cast<float>(pixels.full_well_electrons);
  std::uint64_t state = mixBits(mixBits(seed) + kGoldenStep * image_number);
  std::uint64_t word = 0;
  std::vector<std::uint8_t> values(electrons.size());
  for (std::size_t i = 0; i < electrons.size(); ++i) {
    if (i % kDrawsPerWord == 0) word = mixBits(state += kGoldenStep);
    const float gaussian = quantiles[word & kQuantileMask];
    word >>= kQuantileBits;
    const float noisy = electrons[i] + std::sqrt(electrons[i] + read_variance) * gaussian;
    const float value = std::clamp(noisy * values_per_electron, 0.0F, largest);
    values[i] = static_cast<std::uint8_t>(value + 0.5F);
  }
  return values;
}

void ImageEncoding::declare(Parameters& params) {
  constexpr int kBestQuality = 100;
  constexpr double kLargestResponse = 2.0;  // green is the most sensitive in every known sensor
  params.choice("camera/encoding", layoutNames(), layout);
  params.integer("camera/jpeg_quality", jpeg_quality, 0, kBestQuality);
  params.that(jpeg_quality == 0 || !isMosaic(layout),
              "camera/jpeg_quality must be 0 for a mosaic in camera/encoding: JPEG destroys it");
  params.number("camera/red_response", red_response, 0.0, kLargestResponse);
  params.number("camera/blue_response", blue_response, 0.0, kLargestResponse);
}

double ImageEncoding::responseAt(int column, int row) const {
  if (layout == Layout::kMono8) return 1.0;
  constexpr int kColours = 6;  // they follow "bayer_": of pixels (0, 0), (1, 0), (0, 1), (1, 1)
  const Layout mosaic = isMosaic(layout) ? layout : Layout::kBayerRggb8;
  const std::string& name = layoutNames()[static_cast<std::size_t>(mosaic)];
  const char colour = name[static_cast<std::size_t>(kColours + 2 * (row % 2) + column % 2)];
  if (colour == 'r') return red_response;
  return colour == 'b' ? blue_response : 1.0;
}

const std::vector<std::string>& layoutNames() {
  static const std::vector<std::string> names = {"mono8",       "bayer_rggb8", "bayer_bggr8",
                                                 "bayer_gbrg8", "bayer_grbg8", "bgr8"};
  return names;
}

cv::Mat encode(const cv::Mat& values, const ImageEncoding& encoding) {
  cv::Mat encoded = values;
  if (encoding.layout == Layout::kBgr8) {
    // OpenCV names a mosaic after the second row's second and third pixel.
    cv::cvtColor(values, encoded, cv::COLOR_BayerBG2BGR);
  }
  if (encoding.jpeg_quality == 0) return encoded;
  std::vector<std::uint8_t> file;
  cv::imencode(".jpg", encoded, file, {cv::IMWRITE_JPEG_QUALITY, encoding.jpeg_quality});
  return cv::imdecode(file, cv::IMREAD_UNCHANGED);
}

}  // namespace bearing_calibration::core
