#include "bearing_calibration/simulation/image_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double elevationOf(const Vector3d& unit_vector) { return std::asin(unit_vector.z()); }

/// Calls visit(pixel) for each pixel, row by row.
template <typename Visitor>
void forEachPixel(const CameraRig& rig, const Visitor& visit) {
  for (int v = 0; v < rig.height_px; ++v) {
    for (int u = 0; u < rig.width_px; ++u) visit(Vector2d(u, v));
  }
}

/// What part of the light a pixel gets past the mirror's holders and through its colour filter.
double transmissionAt(const RendererConfig& config, const Vector2d& pixel) {
  constexpr double kLeftByHolder = 0.03;  // it is nearly black
  const Vector2d offset = pixel - config.rig.centre_px;
  const double azimuth_rad = config.rig.handedness * std::atan2(-offset.y(), offset.x());
  const double filter =
      config.encoding.responseAt(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  return isBehind(config.holders, azimuth_rad, 0.0) ? kLeftByHolder * filter : filter;
}

/// The elevations that the mirror shows, and the defocus of a far light as angles in the world.
Panorama::Extent extentOf(const LightSpot& spot) {
  const CameraRig& rig = spot.tracer().rig();
  Panorama::Extent extent{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(),
                          0.0, 0.0};
  forEachPixel(rig, [&](const Vector2d& pixel) {
    const auto direction = spot.tracer().directionSeenBy(pixel);
    if (!direction) return;
    extent.lowest_rad = std::min(extent.lowest_rad, elevationOf(*direction));
    extent.highest_rad = std::max(extent.highest_rad, elevationOf(*direction));
  });
  constexpr double kFar_m = 100.0;  // the spot's size no longer changes beyond
  const SpotMoments moments = spot.moments({{kFar_m, 0.0}});
  if (moments.flux > 0.0) {
    const double radius_px = (moments.mean_px - rig.centre_px).norm();
    extent.azimuth_blur_rad = std::sqrt(moments.covariance_px2(1, 1)) / radius_px;
    // The exit angle changes as much as the ray's angle against the optical axis does.
    extent.elevation_blur_rad = std::sqrt(moments.covariance_px2(0, 0)) / rig.pixelsPerSlope();
  }
  return extent;
}

}  // namespace

void RendererConfig::declare(Parameters& params) {
  constexpr double kBrightest = 1000.0;  // full wells
  rig.declare(params);
  pixels.declare(params);
  shutter.declare(params);
  encoding.declare(params);
  params.number("exposure/reference_value", reference_value, 1.0, PixelConfig::kLargestValue);
  params.number("surroundings/outside_mirror", outside_mirror, 0.0, kBrightest);
  params.number("surroundings/centre_radius", centre_radius_px, 0.0, plausible::kLargestSide_px);
  params.number("surroundings/centre_brightness", centre_brightness, 0.0, kBrightest);
}

ImageRenderer::ImageRenderer(const RendererConfig& config, const RadianceFunction& surroundings)
    : config_(validated(config)),
      spot_(config.rig, config.rays_per_light),
      panorama_(surroundings, extentOf(spot_)) {
  const SpotMoments reference =
      spot_.moments({{config.reference_distance_m, 0.0}, config.reference_height_m});
  if (reference.flux <= 0.0) {
    throw std::invalid_argument(
        "the mirror does not show a light at the distance and height of exposure/reference_value");
  }
  const double full_well = config.pixels.full_well_electrons;
  electrons_per_flux_ =
      config.reference_value / PixelConfig::kLargestValue * full_well / reference.plateau();
  forEachPixel(config.rig, [&](const Vector2d& pixel) {
    const bool is_centre = (pixel - config.rig.centre_px).norm() < config.centre_radius_px;
    const auto direction = is_centre ? std::nullopt : tracer().directionSeenBy(pixel);
    places_.push_back(direction ? panorama_.placeOf(std::atan2(direction->y(), direction->x()),
                                                    elevationOf(*direction))
                                : Panorama::Place());
    fixed_electrons_.push_back(static_cast<float>(
        full_well * (is_centre ? config.centre_brightness : config.outside_mirror)));
    transmission_.push_back(static_cast<float>(transmissionAt(config, pixel)));
  });
  electrons_.resize(places_.size());
}

void ImageRenderer::exposeSurroundings(const SensorMotion& motion) {
  const Shutter& shutter = config_.shutter;
  const float full_well = static_cast<float>(config_.pixels.full_well_electrons);
  // Far away, only the turn counts. Samples within an exposure lie at most a column apart.
  constexpr double kMostSamples = 256.0;
  const double columns_swept =
      std::abs(motion.turn_radps) * shutter.exposure_s * Panorama::kColumns / (2.0 * kPi);
  const int samples = 1 + static_cast<int>(std::min(kMostSamples, columns_swept));
  std::vector<float> turns(static_cast<std::size_t>(samples));
  const auto width = static_cast<std::size_t>(config_.rig.width_px);
  for (std::size_t i = 0; i < electrons_.size(); ++i) {
    if (i % width == 0) {
      const double row_s = static_cast<double>(i / width) * shutter.row_time_s;
      for (int k = 0; k < samples; ++k) {
        const double moment = (k + 0.5) / samples - 0.5;
        const double yaw_rad = motion.world_from_sensor.yaw_rad +
                               motion.turn_radps * (row_s + moment * shutter.exposure_s);
        turns[static_cast<std::size_t>(k)] = Panorama::columnsFrom(yaw_rad);
      }
    }
    if (places_[i].row < 0) {
      electrons_[i] = fixed_electrons_[i];
      continue;
    }
    float sum = 0.0F;
    for (float turn : turns) sum += panorama_.at(places_[i], turn);
    electrons_[i] = full_well * (sum / static_cast<float>(samples));
  }
}

const std::vector<float>& ImageRenderer::expose(const std::vector<Light>& lights,
                                                const SensorMotion& motion) {
  exposeSurroundings(motion);
  for (const Light& light : lights) {
    const auto path = [&](double time_s) { return inSensor(light, motion.poseAt(time_s)); };
    spot_.addTo(path, config_.shutter, electrons_per_flux_, &electrons_);
  }
  for (std::size_t i = 0; i < electrons_.size(); ++i) electrons_[i] *= transmission_[i];
  return electrons_;
}

cv::Mat ImageRenderer::render(const std::vector<Light>& lights, const SensorMotion& motion,
                              std::uint64_t image_number) {
  const std::vector<std::uint8_t> values =
      digitize(expose(lights, motion), config_.pixels, config_.seed, image_number);
  return cv::Mat(values, true).reshape(1, config_.rig.height_px);
}

std::optional<ImageRenderer::Truth> ImageRenderer::truthOf(const Light& light,
                                                           const SensorMotion& motion) const {
  const auto path = [&](double time_s) { return inSensor(light, motion.poseAt(time_s)); };
  const auto row = spot_.rowExposureOf(path, config_.shutter);
  if (!row) return std::nullopt;
  const Vector3d position = path(row->time_s).place_m();
  return Truth{row->time_s, std::atan2(position.y(), position.x()),
               std::atan2(position.z(), position.head<2>().norm()), row->pixel};
}

}  // namespace bearing_calibration::core
