#include "bearing_calibration/simulation/image_renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

LuminousBall referenceLight(const RendererConfig& config) {
  return {{config.reference_distance_m, 0.0, config.reference_height_m}, 1.0, 0.0};
}

LuminousBall ballOf(const Light& light, const Pose2& world_from_sensor) {
  return {positionInSensor(light, world_from_sensor), light.brightness, light.radius_m};
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

/// What part of the light each pixel gets past the mirror's holders and through its colour filter.
std::vector<float> transmissionOf(const RendererConfig& config) {
  constexpr double kLeftByHolder = 0.03;  // it is nearly black
  const bool is_plain =
      config.holders.empty() && config.encoding.layout == ImageEncoding::Layout::kMono8;
  std::vector<float> transmission;
  if (is_plain) return transmission;
  forEachPixel(config.rig, [&](std::size_t, const Vector2d& pixel) {
    const Vector2d offset = pixel - config.rig.centre_px;
    const double azimuth_rad = config.rig.handedness * std::atan2(-offset.y(), offset.x());
    const double filter =
        config.encoding.responseAt(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    const bool is_hidden = isBehind(config.holders, azimuth_rad, 0.0);
    transmission.push_back(static_cast<float>(is_hidden ? kLeftByHolder * filter : filter));
  });
  return transmission;
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

void RendererConfig::declare(Parameters& params) {
  constexpr int kMostRays = 1 << 20;     // a second of work for one light
  constexpr double kBrightest = 1000.0;  // full wells
  using plausible::kFarthest_m;
  rig.declare(params);
  pixels.declare(params);
  shutter.declare(params);
  encoding.declare(params);
  params.number("exposure/reference_value", reference_value, 1.0, PixelNoise::kLargestValue);
  params.number("exposure/reference_distance", reference_distance_m, plausible::kShortest_m,
                kFarthest_m);
  params.number("exposure/reference_height", reference_height_m, -kFarthest_m, kFarthest_m);
  params.number("surroundings/outside_mirror", outside_mirror, 0.0, kBrightest);
  params.number("surroundings/centre_radius", centre_radius_px, 0.0, plausible::kLargestSide_px);
  params.number("surroundings/centre_brightness", centre_brightness, 0.0, kBrightest);
  params.integer("camera/rays_per_light", rays_per_light, 1, kMostRays);
}

ImageRenderer::ImageRenderer(const RendererConfig& config, const RadianceFunction& surroundings)
    : config_(validated(config)),
      tracer_(config.rig),
      noise_(config.pixels, config.seed),
      spot_(config.rig, config.rays_per_light),
      panorama_(surroundings, extentOf(config, tracer_, spot_)),
      transmission_(transmissionOf(config)) {
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

void ImageRenderer::exposeSurroundings(const SensorMotion& motion, const Shutter& shutter) {
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

void ImageRenderer::attenuate() {
  for (std::size_t i = 0; i < transmission_.size(); ++i) electrons_[i] *= transmission_[i];
}

const std::vector<float>& ImageRenderer::expose(const std::vector<Light>& lights,
                                                const Pose2& world_from_sensor) {
  exposeSurroundings({world_from_sensor, Vector2d::Zero(), 0.0}, {});
  for (const Light& light : lights) {
    spot_.addTo(tracer_, ballOf(light, world_from_sensor), electrons_per_flux_, &electrons_);
  }
  attenuate();
  return electrons_;
}

const std::vector<float>& ImageRenderer::exposeMoving(const std::vector<Light>& lights,
                                                      const SensorMotion& motion) {
  if (config_.shutter.isInstant()) return expose(lights, motion.world_from_sensor);
  exposeSurroundings(motion, config_.shutter);
  for (const Light& light : lights) {
    const auto path = [&](double time_s) { return ballOf(light, motion.poseAt(time_s)); };
    spot_.addMovingTo(tracer_, path, config_.shutter, electrons_per_flux_, &electrons_);
  }
  attenuate();
  return electrons_;
}

MonoImage ImageRenderer::render(const std::vector<Light>& lights, const Pose2& world_from_sensor,
                                std::uint64_t image_number) {
  MonoImage image{config_.rig.width_px, config_.rig.height_px, {}};
  noise_.digitize(expose(lights, world_from_sensor), image_number, &image.values);
  return image;
}

MonoImage ImageRenderer::renderMoving(const std::vector<Light>& lights, const SensorMotion& motion,
                                      std::uint64_t image_number) {
  MonoImage image{config_.rig.width_px, config_.rig.height_px, {}};
  noise_.digitize(exposeMoving(lights, motion), image_number, &image.values);
  return image;
}

std::optional<ImageRenderer::Truth> ImageRenderer::truthOf(const Light& light,
                                                           const SensorMotion& motion) const {
  const auto path = [&](double time_s) { return ballOf(light, motion.poseAt(time_s)); };
  const auto row = LightSpot::rowExposureOf(tracer_, path, config_.shutter);
  if (!row) return std::nullopt;
  const Vector3d position = path(row->time_s).position_m;
  return Truth{row->time_s, std::atan2(position.y(), position.x()),
               std::atan2(position.z(), position.head<2>().norm()), row->pixel};
}

}  // namespace bearing_calibration::core
