#include "bearing_calibration/vision/expected_spot.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_ellipse.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRingStddev = 0.70710678118654752;  // of cos over a circle
// Diffraction, aberrations and the filter in front of the pixels: a standard deviation up to this.
constexpr double kLensBlur_px = 0.5;
constexpr int kDistances = 8;  // the blur changes slowly with the distance

struct Stddevs {
  double tangential_px;
  double radial_px;
  double open_tangential_px;  ///< of the open aperture's evenly filled ellipse alone
  double open_radial_px;
};

/// Fourth moment over squared second one of the aperture's ellipse together with all else, which is
/// taken for Gaussian: E(m^4) = 8 - t^2 - r^2 - 2/3 t r, where t and r are the ellipse's parts of
/// the variances along the azimuth and the radius, and E(m^2) = 2.
double kurtosisOf(const Stddevs& stddevs, double lens_px) {
  const auto part = [&](double open_px, double all_px) {
    return open_px * open_px / (all_px * all_px + lens_px * lens_px);
  };
  const double t = part(stddevs.open_tangential_px, stddevs.tangential_px);
  const double r = part(stddevs.open_radial_px, stddevs.radial_px);
  return 2.0 - 0.25 * (t * t + r * r + 2.0 / 3.0 * t * r);
}

/// Standard deviations of the image of a light at one distance.
Stddevs stddevsAt(const DetectorConfig& config, double image_radius_px, double distance_m) {
  const SpotBlur blur = expectedBlur(config.mirror, image_radius_px, distance_m);
  // Light on a ring's outline has a deviation of radius / sqrt(2), anything filled less.
  const double extent_rad = config.light.radius_m / distance_m * kRingStddev;
  const double tangential_extent = extent_rad * image_radius_px;
  // The ring's near and far side stand at different elevations unless the mirror looks level.
  const double height_rad =
      std::hypot(config.light.half_height_m / distance_m * kRingStddev,
                 std::tan(elevationFromRadius(config.mirror, image_radius_px)) * extent_rad);
  const double radial_extent = height_rad / elevationSlope(config.mirror, image_radius_px);
  const double common = kPixelVariance + std::pow(config.defocus_sigma_px, 2);
  constexpr double kBlurToStddev = 0.25;  // of an evenly filled ellipse
  const double open_tangential_px = kBlurToStddev * blur.tangential_diameter_px;
  const double open_radial_px = kBlurToStddev * blur.radial_diameter_px;
  return {std::sqrt(std::pow(open_tangential_px, 2) + std::pow(tangential_extent, 2) + common),
          std::sqrt(std::pow(open_radial_px, 2) + std::pow(radial_extent, 2) + common),
          open_tangential_px, open_radial_px};
}

void include(Range* range, double value) {
  range->low = std::min(range->low, value);
  range->high = std::max(range->high, value);
}

/// Area of the ellipse with these standard deviations.
double area(double tangential_px, double radial_px) {
  return 4.0 * kPi * tangential_px * radial_px;
}

}  // namespace

SpotSize expectedSpotSize(const DetectorConfig& config, double image_radius_px) {
  // In the mirror's very centre the azimuth has no meaning and the cone no curvature.
  const double radius_px = std::clamp(image_radius_px, 1.0, rimRadiusPx(config.mirror));
  const Range nothing{std::numeric_limits<double>::infinity(), 0.0};
  SpotSize size{nothing, nothing, 0.0};
  const double step = 1.0 / (kDistances - 1);
  const double nearest = 1.0 / config.light.min_distance_m;
  const double farthest = 1.0 / config.light.max_distance_m;
  for (int i = 0; i < kDistances; ++i) {
    const double distance_m = 1.0 / (nearest + (farthest - nearest) * i * step);
    const Stddevs stddevs = stddevsAt(config, radius_px, distance_m);
    for (double lens_px : {0.0, kLensBlur_px}) {
      include(&size.tangential_stddev_px, std::hypot(stddevs.tangential_px, lens_px));
      include(&size.radial_stddev_px, std::hypot(stddevs.radial_px, lens_px));
      size.max_kurtosis = std::max(size.max_kurtosis, kurtosisOf(stddevs, lens_px));
    }
  }
  return size;
}

ExpectedSpot::ExpectedSpot(const DetectorConfig& config)
    : area_px_{std::numeric_limits<double>::infinity(), 0.0} {
  if (!config.gates.mirror) {
    sizes_.emplace_back();
    return;
  }
  const double rim_px = rimRadiusPx(config.mirror);
  const int last = static_cast<int>(std::ceil(std::min(rim_px, config.mask.outer_radius_px)));
  for (int radius = 0; radius <= last; ++radius) {
    const SpotSize size = expectedSpotSize(config, radius);
    sizes_.push_back(size);
    if (radius < config.mask.inner_radius_px) continue;
    include(&area_px_, area(size.tangential_stddev_px.low, size.radial_stddev_px.low));
    include(&area_px_, area(size.tangential_stddev_px.high, size.radial_stddev_px.high));
    largest_stddev_px_ =
        std::max({largest_stddev_px_, size.tangential_stddev_px.high, size.radial_stddev_px.high});
  }
}

const SpotSize& ExpectedSpot::at(double image_radius_px) const {
  const double last = static_cast<double>(sizes_.size() - 1);
  return sizes_[static_cast<std::size_t>(std::clamp(image_radius_px, 0.0, last) + 0.5)];
}

}  // namespace bearing_calibration::core
