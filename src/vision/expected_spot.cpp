#include "bearing_calibration/vision/expected_spot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_ellipse.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRingStddev = 0.70710678118654752;  // of cos over a circle
// Diffraction, aberrations and the filter in front of the pixels: a standard deviation up to this.
constexpr double kLensBlur_px = 0.5;
constexpr double kSigmas = 2.5;  // of the optics, that are thought possible
constexpr int kDistances = 8;    // the blur changes slowly with the distance

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
Stddevs stddevsAt(const DetectorConfig& config, double image_radius_px, double distance_m,
                  double part_of_light) {
  const SpotBlur blur = expectedBlur(config.mirror, image_radius_px, distance_m);
  // Light on a ring's outline has a deviation of radius / sqrt(2), anything filled less.
  const double extent_rad = part_of_light * config.light.radius_m / distance_m * kRingStddev;
  const double tangential_extent = extent_rad * image_radius_px;
  // The ring's near and far side stand at different elevations unless the mirror looks level.
  const double height_rad =
      std::hypot(part_of_light * config.light.half_height_m / distance_m * kRingStddev,
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

/// Of the largest light, the smallest one's size.
double smallestPart(const LightModel& light) {
  return light.radius_m > 0.0 ? light.min_radius_m / light.radius_m : 0.0;
}

/// Logarithms of the smallest light's standard deviations (tangential, radial), for this lens'
/// blur.
Eigen::Vector2d logPoint(const DetectorConfig& config, double radius_px, double distance_m,
                         double lens_px) {
  const Stddevs stddevs = stddevsAt(config, radius_px, distance_m, smallestPart(config.light));
  return {std::log(std::hypot(stddevs.tangential_px, lens_px)),
          std::log(std::hypot(stddevs.radial_px, lens_px))};
}

/// The rig with each of its optics' values off by `sigmas` of its standard deviations.
std::array<ConicMirror, 4> mirrorsOff(const DetectorConfig& config, double sigmas) {
  const OpticsUncertainty& stddev = config.optics_stddev;
  std::array<ConicMirror, 4> mirrors;
  mirrors.fill(config.mirror);
  mirrors[0].pixel_pitch_m *= 1.0 - sigmas * stddev.scale;
  mirrors[1].aperture_m *= 1.0 + sigmas * stddev.aperture;
  // No lens is focused nearer than its focal length.
  mirrors[2].focus_distance_m =
      std::max(1.01 * config.mirror.focal_length_m,
               config.mirror.focus_distance_m * (1.0 + sigmas * stddev.focus));
  mirrors[3].half_angle_rad += sigmas * stddev.half_angle_rad;
  return mirrors;
}

/// Where a point's size is expected, and how well that is known.
void expectPoint(const DetectorConfig& config, double radius_px, SpotSize* size) {
  // What noise, clipping and the threshold do to a measured size.
  constexpr double kMeasured = 0.06;
  constexpr double kUsualBlur_px = 0.25;
  const LightModel& light = config.light;
  const double usual_m = std::sqrt(light.min_distance_m * light.max_distance_m);
  size->log_point = logPoint(config, radius_px, usual_m, kUsualBlur_px);
  size->log_covariance = kMeasured * kMeasured * Eigen::Matrix2d::Identity();
  const auto add = [&](const Eigen::Vector2d& log_stddevs) {  // one side of two
    const Eigen::Vector2d off = log_stddevs - size->log_point;
    size->log_covariance += 0.5 * off * off.transpose();
  };
  for (double distance_m : {light.min_distance_m, light.max_distance_m}) {
    add(logPoint(config, radius_px, distance_m, kUsualBlur_px));
  }
  for (double lens_px : {0.0, kLensBlur_px}) add(logPoint(config, radius_px, usual_m, lens_px));
  DetectorConfig other = config;
  for (double sigmas : {-1.0, 1.0}) {
    for (const ConicMirror& mirror : mirrorsOff(config, sigmas)) {
      other.mirror = mirror;
      add(logPoint(other, radius_px, usual_m, kUsualBlur_px));
    }
  }
}

}  // namespace

Range SpotSize::widened(const Range& range, double log_variance) {
  const double factor = std::exp(kSigmas * std::sqrt(log_variance));
  return {range.low / factor, range.high * factor};
}

SpotSize expectedSpotSize(const DetectorConfig& config, double image_radius_px) {
  // In the mirror's very centre the azimuth has no meaning and the cone no curvature.
  const double radius_px = std::clamp(image_radius_px, 1.0, rimRadiusPx(config.mirror));
  const Range nothing{std::numeric_limits<double>::infinity(), 0.0};
  SpotSize size;
  size.tangential_stddev_px = size.radial_stddev_px = nothing;
  expectPoint(config, radius_px, &size);
  const double step = 1.0 / (kDistances - 1);
  const double nearest = 1.0 / config.light.min_distance_m;
  const double farthest = 1.0 / config.light.max_distance_m;
  for (int i = 0; i < kDistances; ++i) {
    const double distance_m = 1.0 / (nearest + (farthest - nearest) * i * step);
    for (double part_of_light : {smallestPart(config.light), 1.0}) {
      const Stddevs stddevs = stddevsAt(config, radius_px, distance_m, part_of_light);
      for (double lens_px : {0.0, kLensBlur_px}) {
        include(&size.tangential_stddev_px, std::hypot(stddevs.tangential_px, lens_px));
        include(&size.radial_stddev_px, std::hypot(stddevs.radial_px, lens_px));
        if (part_of_light > smallestPart(config.light)) continue;
        size.max_kurtosis = std::max(size.max_kurtosis, kurtosisOf(stddevs, lens_px));
      }
    }
  }
  return size;
}

double largestRadiusPx(const DetectorConfig& config) {
  const double rim_px = rimRadiusPx(config.mirror);
  const double elevation_rad = std::atan(config.light.max_height_m / config.light.min_distance_m);
  if (elevation_rad >= elevationFromRadius(config.mirror, rim_px)) return rim_px;
  const double radius_px = std::max(0.0, radiusFromElevation(config.mirror, elevation_rad));
  const double stddev_px = std::hypot(
      radius_px * config.optics_stddev.scale,
      2.0 * config.optics_stddev.half_angle_rad / elevationSlope(config.mirror, radius_px));
  return std::min(rim_px, radius_px + kSigmas * stddev_px);
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
    const Range tangential = size.possibleTangential_px();
    const Range radial = size.possibleRadial_px();
    include(&area_px_, area(tangential.low, radial.low));
    include(&area_px_, area(tangential.high, radial.high));
    largest_point_stddev_px_ =
        std::max(largest_point_stddev_px_, size.pointStddev_px(0.0).maxCoeff());
  }
}

const SpotSize& ExpectedSpot::at(double image_radius_px) const {
  const double last = static_cast<double>(sizes_.size() - 1);
  return sizes_[static_cast<std::size_t>(std::clamp(image_radius_px, 0.0, last) + 0.5)];
}

}  // namespace bearing_calibration::core
