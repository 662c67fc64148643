#include "bearing_calibration/simulation/light_spot.h"

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// The golden angle: points at sqrt(i) and i times this angle fill a disc evenly (Vogel's spiral).
const double kGoldenAngle_rad = kPi * (3.0 - std::sqrt(5.0));

// Steps of the two-dimensional low-discrepancy sequence made from the plastic number p,
// p^3 = p + 1: the n-th point is the fraction of (n / p, n / p^2).
constexpr double kPlasticStep = 0.7548776662466927;
constexpr double kPlasticStepSquared = kPlasticStep * kPlasticStep;

// For the moments of rays: independent of the golden angle's and the plastic number's multiples.
constexpr double kRootOfTwo = 1.4142135623730951;

Vector2d onDisc(double area_fraction, double angle_rad) {
  return std::sqrt(area_fraction) * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double fraction(double value) { return value - std::floor(value); }

/// Where a ray starts that comes from the place `ball` of a light's unit disc.
Vector3d sourceOf(const Light& light, const Vector2d& ball) {
  const Vector2d sideways = light.radius_m * perpendicular(light.position_m).normalized();
  Vector3d source = light.place_m();
  source.head<2>() += ball.x() * sideways;
  source.z() += ball.y() * light.radius_m;
  return source;
}

/// Adds `amount` to the four pixels that a pixel-wide square around `pixel` covers.
void shareOut(const CameraRig& rig, const Vector2d& pixel, double amount,
              std::vector<float>* electrons) {
  const auto add = [&](int u, int v, double part) {
    if (u < 0 || v < 0 || u >= rig.width_px || v >= rig.height_px) return;
    (*electrons)[static_cast<std::size_t>(v * rig.width_px + u)] += static_cast<float>(part);
  };
  const int u = static_cast<int>(std::floor(pixel.x()));
  const int v = static_cast<int>(std::floor(pixel.y()));
  const double right = pixel.x() - u;
  const double below = pixel.y() - v;
  add(u, v, amount * (1.0 - right) * (1.0 - below));
  add(u + 1, v, amount * right * (1.0 - below));
  add(u, v + 1, amount * (1.0 - right) * below);
  add(u + 1, v + 1, amount * right * below);
}

}  // namespace

double SpotMoments::plateau() const {
  // A filled ellipse of half axes a, b has the variances a^2/4, b^2/4: its area is 4 pi sqrt(det).
  return flux / (4.0 * kPi * std::sqrt(covariance_px2.determinant()));
}

LightSpot::LightSpot(const CameraRig& rig, int rays) : tracer_(rig) {
  if (rays <= 0) throw std::invalid_argument("a light needs at least one ray");
  const double radius_m = 0.5 * rig.aperture_m;
  area_per_ray_m2_ = kPi * radius_m * radius_m / rays;
  samples_.reserve(static_cast<std::size_t>(rays));
  for (int i = 0; i < rays; ++i) {
    samples_.push_back(
        {radius_m * onDisc((i + 0.5) / rays, i * kGoldenAngle_rad),
         onDisc(fraction(i * kPlasticStep), 2.0 * kPi * fraction(i * kPlasticStepSquared)),
         fraction((i + 0.5) * kRootOfTwo) - 0.5});
  }
}

std::optional<LightSpot::RowExposure> LightSpot::rowExposureOf(const LightPath& path,
                                                               const Shutter& shutter) const {
  // The row moves the time, and the time the row by less than a hundredth of that: fixed point.
  constexpr int kRounds = 5;
  RowExposure row;
  for (int round = 0; round < kRounds; ++round) {
    const auto hit = tracer_.rayFrom(path(row.time_s).place_m(), Vector2d::Zero());
    if (!hit) return std::nullopt;
    row.pixel = hit->pixel;
    row.time_s = hit->pixel.y() * shutter.row_time_s;
  }
  return row;
}

void LightSpot::trace(const LightPath& path, const Shutter& shutter,
                      const RayVisitor& visit) const {
  const auto middle = rowExposureOf(path, shutter);
  if (!middle && !shutter.isInstant()) return;
  // From the middle's row to the ray's own in two rounds, the second of which moves it by less
  // than a thousandth of a pixel.
  const int rounds = shutter.row_time_s > 0.0 ? 2 : 1;
  for (const Sample& sample : samples_) {
    double row = middle ? middle->pixel.y() : 0.0;
    for (int round = 1; round <= rounds; ++round) {
      const Light light = path(row * shutter.row_time_s + sample.moment * shutter.exposure_s);
      const auto hit = tracer_.rayFrom(sourceOf(light, sample.ball), sample.aperture_m);
      if (!hit) break;
      row = hit->pixel.y();
      if (round == rounds) {
        visit(hit->pixel, light.brightness * hit->throughput * area_per_ray_m2_);
      }
    }
  }
}

SpotMoments LightSpot::moments(const Light& light) const {
  SpotMoments moments;
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  const Vector2d origin = tracer_.rig().centre_px;  // keeps the sums of squares small
  trace([&light](double) { return light; }, Shutter(),
        [&](const Vector2d& pixel, double flux) {
          const Vector2d offset = pixel - origin;
          moments.flux += flux;
          moments.mean_px += flux * offset;
          square += flux * offset * offset.transpose();
        });
  if (moments.flux <= 0.0) return moments;
  moments.mean_px /= moments.flux;
  moments.covariance_px2 = square / moments.flux - moments.mean_px * moments.mean_px.transpose();
  moments.mean_px += origin;
  return moments;
}

void LightSpot::addTo(const LightPath& path, const Shutter& shutter, double electrons_per_flux,
                      std::vector<float>* electrons) const {
  trace(path, shutter, [&](const Vector2d& pixel, double flux) {
    shareOut(tracer_.rig(), pixel, flux * electrons_per_flux, electrons);
  });
}

}  // namespace bearing_calibration::core
