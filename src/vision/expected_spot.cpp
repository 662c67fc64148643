#include "bearing_calibration/vision/expected_spot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/detection.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Array2d;  // (tangential, radial)
using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Diffraction, aberrations and the filter in front of the pixels: a standard deviation up to this.
constexpr double kLensBlur_px = 0.5;
constexpr double kSigmas = 2.5;  // of the optics, that are thought possible
constexpr int kDistances = 8;    // the blur changes slowly with the distance

/// Of the image of a light at one distance.
struct Stddevs {
  Array2d open_px;  ///< of the open aperture's evenly filled ellipse alone
  Array2d all_px;   ///< with the light's own size, the pixels' and the software's defocus

  Array2d behindLens(double lens_px) const { return (all_px.square() + lens_px * lens_px).sqrt(); }
  double kurtosis(double lens_px) const;
};

Stddevs stddevsAt(const DetectorConfig& config, double image_radius_px, double distance_m,
                  double part_of_light) {
  const double part = part_of_light * kRingStddev;
  const SpotVariances spot =
      spotVariances(config.mirror, image_radius_px, distance_m, part * config.light.radius_m,
                    part * config.light.half_height_m);
  const double common_px2 = kPixelVariance + std::pow(config.defocus_sigma_px, 2);
  return {spot.open_px2.sqrt(), (spot.open_px2 + spot.own_px2 + common_px2).sqrt()};
}

/// Fourth moment over squared second one of the aperture's ellipse together with all else, which is
/// taken for Gaussian: E(m^4) = 8 - t^2 - r^2 - 2/3 t r, where t and r are the ellipse's parts of
/// the variances along the azimuth and the radius, and E(m^2) = 2.
double Stddevs::kurtosis(double lens_px) const {
  const Array2d parts = open_px.square() / (all_px.square() + lens_px * lens_px);
  return 2.0 - 0.25 * (parts.square().sum() + 2.0 / 3.0 * parts.prod());
}

/// Of the largest light, the smallest one's size.
double smallestPart(const LightModel& light) {
  return light.radius_m > 0.0 ? light.min_radius_m / light.radius_m : 0.0;
}

/// Logarithms of the smallest light's standard deviations, for this lens' blur.
Vector2d logPoint(const DetectorConfig& config, double radius_px, double distance_m,
                  double lens_px) {
  return stddevsAt(config, radius_px, distance_m, smallestPart(config.light))
      .behindLens(lens_px)
      .log();
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
  const auto add = [&](const Vector2d& log_stddevs) {  // one side of two
    const Vector2d off = log_stddevs - size->log_point;
    size->log_covariance += 0.5 * off * off.transpose();
  };
  for (double distance_m : {light.min_distance_m, light.max_distance_m}) {
    add(logPoint(config, radius_px, distance_m, kUsualBlur_px));
  }
  for (double lens_px : {0.0, kLensBlur_px}) add(logPoint(config, radius_px, usual_m, lens_px));
  DetectorConfig other = config;
  for (double sigmas : {-1.0, 1.0}) {
    for (const ConicMirror& mirror : mirrorsOff(config, sigmas)) {
      if (!showsOutside(mirror, radius_px, usual_m)) continue;  // no optics that show a light there
      other.mirror = mirror;
      add(logPoint(other, radius_px, usual_m, kUsualBlur_px));
    }
  }
}

/// By image radius in whole pixels, as far as the mask or the mirror reaches.
std::vector<SpotSize> sizesOver(const DetectorConfig& config) {
  const double end_px = std::min(rimRadiusPx(config.mirror), config.mask.outer_radius_px);
  std::vector<SpotSize> sizes;
  for (int radius = 0; radius <= static_cast<int>(std::ceil(end_px)); ++radius) {
    sizes.push_back(spotSizeAt(config, radius));
  }
  return sizes;
}

}  // namespace

SpotVariances spotVariances(const ConicMirror& mirror, double image_radius_px, double distance_m,
                            double sideways_stddev_m, double upward_stddev_m) {
  const SpotBlur blur = expectedBlur(mirror, image_radius_px, distance_m);
  constexpr double kBlurToStddev = 0.25;  // of an evenly filled ellipse
  const Array2d open_px(kBlurToStddev * blur.tangential_diameter_px,
                        kBlurToStddev * blur.radial_diameter_px);
  const double sideways_rad = sideways_stddev_m / distance_m;
  // Its near and far side stand at different elevations unless the mirror looks level.
  const double upward_rad =
      std::hypot(upward_stddev_m / distance_m,
                 std::tan(elevationFromRadius(mirror, image_radius_px)) * sideways_rad);
  const Array2d own_px(sideways_rad * image_radius_px,
                       upward_rad / elevationSlope(mirror, image_radius_px));
  return {open_px.square(), own_px.square()};
}

SpotSize spotSizeAt(const DetectorConfig& config, double image_radius_px) {
  // In the mirror's very centre the azimuth has no meaning and the cone no curvature.
  const double radius_px = std::clamp(image_radius_px, 1.0, rimRadiusPx(config.mirror));
  SpotSize size;
  size.least_stddev_px.setConstant(kInfinity);
  expectPoint(config, radius_px, &size);
  const double smallest = smallestPart(config.light);
  const double step = 1.0 / (kDistances - 1);
  const double nearest = 1.0 / config.light.min_distance_m;
  const double farthest = 1.0 / config.light.max_distance_m;
  for (int i = 0; i < kDistances; ++i) {
    const double distance_m = 1.0 / (nearest + (farthest - nearest) * i * step);
    for (double part_of_light : {smallest, 1.0}) {
      const Stddevs stddevs = stddevsAt(config, radius_px, distance_m, part_of_light);
      for (double lens_px : {0.0, kLensBlur_px}) {
        const Vector2d seen_px = stddevs.behindLens(lens_px);
        size.least_stddev_px = size.least_stddev_px.cwiseMin(seen_px);
        size.most_stddev_px = size.most_stddev_px.cwiseMax(seen_px);
        if (part_of_light > smallest) continue;
        size.max_kurtosis = std::max(size.max_kurtosis, stddevs.kurtosis(lens_px));
      }
    }
  }
  return size;
}

double largestLightRadiusPx(const DetectorConfig& config) {
  const double rim_px = rimRadiusPx(config.mirror);
  const double elevation_rad = std::atan(config.light.max_height_m / config.light.min_distance_m);
  if (elevation_rad >= elevationFromRadius(config.mirror, rim_px)) return rim_px;
  const double radius_px = std::max(0.0, radiusFromElevation(config.mirror, elevation_rad));
  const double stddev_px = std::hypot(
      radius_px * config.optics_stddev.scale,
      2.0 * config.optics_stddev.half_angle_rad / elevationSlope(config.mirror, radius_px));
  return std::min(rim_px, radius_px + kSigmas * stddev_px);
}

Vector2d SpotSize::pointStddev_px(double sigmas) const {
  return (log_point + sigmas * log_covariance.diagonal().cwiseSqrt()).array().exp();
}

Vector2d SpotSize::widening() const {
  return (kSigmas * log_covariance.diagonal().cwiseSqrt()).array().exp();
}

ExpectedSpot::ExpectedSpot(const DetectorConfig& config)
    : ExpectedSpot(sizesOver(config), largestLightRadiusPx(config), config) {}

ExpectedSpot::ExpectedSpot(std::vector<SpotSize> sizes, double largest_radius_px,
                           const DetectorConfig& config)
    : sizes_(std::move(sizes)),
      largest_radius_px_(largest_radius_px),
      centre_px_(config.view.centre_px()),
      area_px_{kInfinity, 0.0} {
  for (std::size_t radius = 0; radius < sizes_.size(); ++radius) {
    if (static_cast<double>(radius) < config.mask.inner_radius_px) continue;
    constexpr double kArea = 4.0 * kPi;  // of an ellipse with these standard deviations
    const SpotSize& size = sizes_[radius];
    const Vector2d widening = size.widening();
    const double least_px2 = size.least_stddev_px.cwiseQuotient(widening).prod();
    const double most_px2 = size.most_stddev_px.cwiseProduct(widening).prod();
    area_px_.low = std::min(area_px_.low, kArea * least_px2);
    area_px_.high = std::max(area_px_.high, kArea * most_px2);
    largest_point_stddev_px_ =
        std::max(largest_point_stddev_px_, size.pointStddev_px(0.0).maxCoeff());
  }
}

const SpotSize& ExpectedSpot::at(const Vector2d& place_px) const {
  const double last = static_cast<double>(sizes_.size() - 1);
  const double radius_px = std::min((place_px - centre_px_).norm(), last);
  return sizes_[static_cast<std::size_t>(radius_px + 0.5)];
}

bool ExpectedSpot::mayStandAt(const Vector2d& place_px) const {
  return (place_px - centre_px_).norm() <= largest_radius_px_;
}

}  // namespace bearing_calibration::core
