#include "bearing_calibration/simulation/image_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

LuminousBall referenceLight(const RendererConfig& config) {
  return {{config.reference_distance_m, 0.0, config.reference_height_m}, 1.0, 0.0};
}

double elevationOf(const Vector3d& unit_vector) { return std::asin(unit_vector.z()); }

bool insideCentre(const RendererConfig& config, const Vector2d& pixel) {
  return (pixel - config.rig.centre_px).norm() < config.centre_radius_px;
}

/// Calls visit(index, pixel) for each pixel, row by row.
template <typename Visitor>
void forEachPixel(const CameraRig& rig, const Visitor& visit) {
  std::size_t index = 0;
  for (int v = 0; v < rig.height_px; ++v) {
    for (int u = 0; u < rig.width_px; ++u) visit(index++, Vector2d(u, v));
  }
}

/// The defocus of a far light, as angles in the world.
Panorama::Extent extentOf(const RendererConfig& config, const ConeTracer& tracer,
                          const LightSpot& spot) {
  Panorama::Extent extent{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(),
                          0.0, 0.0};
  forEachPixel(config.rig, [&](std::size_t, const Vector2d& pixel) {
    const auto direction = tracer.directionSeenBy(pixel);
    if (!direction) return;
    extent.lowest_rad = std::min(extent.lowest_rad, elevationOf(*direction));
    extent.highest_rad = std::max(extent.highest_rad, elevationOf(*direction));
  });
  constexpr double kFar_m = 100.0;  // the spot's size no longer changes beyond
  const SpotMoments moments = spot.moments(tracer, {{kFar_m, 0.0, 0.0}, 1.0, 0.0});
  if (moments.flux > 0.0) {
    const double radius_px = (moments.mean_px - config.rig.centre_px).norm();
    extent.azimuth_blur_rad = std::sqrt(moments.covariance_px2(1, 1)) / radius_px;
    // The exit angle changes as much as the ray's angle against the optical axis does.
    extent.elevation_blur_rad =
        std::sqrt(moments.covariance_px2(0, 0)) / config.rig.pixelsPerSlope();
  }
  return extent;
}

}  // namespace

std::vector<std::string> RendererConfig::validate() const {
  constexpr int kMostRays = 1 << 20;  // a second of work for one light
  Requirements require;
  require.add(rig.validate());
  require.add(pixels.validate());
  require.between("exposure/reference_value", reference_value, 1.0, PixelNoise::kLargestValue);
  require.positive("exposure/reference_distance", reference_distance_m);
  require.that(std::isfinite(reference_height_m), "exposure/reference_height must be finite");
  require.notNegative("surroundings/outside_mirror", outside_mirror);
  require.notNegative("surroundings/centre_radius", centre_radius_px);
  require.notNegative("surroundings/centre_brightness", centre_brightness);
  require.between("camera/rays_per_light", rays_per_light, 1, kMostRays);
  return require.errors();
}

ImageRenderer::ImageRenderer(const RendererConfig& config, const RadianceFunction& surroundings)
    : config_(validated(config)),
      tracer_(config.rig),
      noise_(config.pixels, config.seed),
      spot_(config.rig, config.rays_per_light),
      panorama_(surroundings, extentOf(config, tracer_, spot_)) {
  const SpotMoments reference = spot_.moments(tracer_, referenceLight(config));
  if (reference.flux <= 0.0) {
    throw std::invalid_argument("the mirror does not show a light at exposure/reference_distance");
  }
  const double full_well = config.pixels.full_well_electrons;
  electrons_per_flux_ =
      config.reference_value / PixelNoise::kLargestValue * full_well / reference.plateau();
  const std::size_t size = static_cast<std::size_t>(config.rig.width_px) *
                           static_cast<std::size_t>(config.rig.height_px);
  places_.resize(size);
  fixed_electrons_.resize(size);
  electrons_.resize(size);
  forEachPixel(config.rig, [&](std::size_t index, const Vector2d& pixel) {
    const bool is_centre = insideCentre(config_, pixel);
    const auto direction = is_centre ? std::nullopt : tracer_.directionSeenBy(pixel);
    if (direction) {
      places_[index] =
          panorama_.placeOf(std::atan2(direction->y(), direction->x()), elevationOf(*direction));
    } else {
      fixed_electrons_[index] = static_cast<float>(
          full_well * (is_centre ? config_.centre_brightness : config_.outside_mirror));
    }
  });
}

const std::vector<float>& ImageRenderer::expose(const std::vector<Light>& lights,
                                                const Pose2& world_from_sensor) {
  const float full_well = static_cast<float>(config_.pixels.full_well_electrons);
  const float columns_turned = Panorama::columnsFrom(world_from_sensor.yaw_rad);
  for (std::size_t i = 0; i < electrons_.size(); ++i) {
    electrons_[i] = places_[i].row < 0 ? fixed_electrons_[i]
                                       : full_well * panorama_.at(places_[i], columns_turned);
  }
  for (const Light& light : lights) {
    spot_.addTo(tracer_,
                {positionInSensor(light, world_from_sensor), light.brightness, light.radius_m},
                electrons_per_flux_, &electrons_);
  }
  return electrons_;
}

MonoImage ImageRenderer::render(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                                std::uint64_t image_number) {
  MonoImage image{config_.rig.width_px, config_.rig.height_px, {}};
  noise_.digitize(expose(lights, world_from_sensor), image_number, &image.values);
  return image;
}

}  // namespace bearing_calibration
