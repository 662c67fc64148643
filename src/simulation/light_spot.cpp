#include "bearing_calibration/simulation/light_spot.h"

#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// The golden angle: points at sqrt(i) and i times this angle fill a disc evenly (Vogel's spiral).
const double kGoldenAngle_rad = kPi * (3.0 - std::sqrt(5.0));

// Steps of the two-dimensional low-discrepancy sequence made from the plastic number p,
// p^3 = p + 1: the n-th point is the fraction of (n / p, n / p^2).
constexpr double kPlasticStep = 0.7548776662466927;
constexpr double kPlasticStepSquared = kPlasticStep * kPlasticStep;

Vector2d onDisc(double area_fraction, double angle_rad) {
  return std::sqrt(area_fraction) * Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double fraction(double value) { return value - std::floor(value); }

}  // namespace

double SpotMoments::plateau() const {
  // A filled ellipse of half axes a, b has the variances a^2/4, b^2/4: its area is 4 pi sqrt(det).
  return flux / (4.0 * kPi * std::sqrt(covariance_px2.determinant()));
}

LightSpot::LightSpot(const CameraRig& rig, int rays) {
  if (rays <= 0) throw std::invalid_argument("a light needs at least one ray");
  const double radius_m = 0.5 * rig.aperture_m;
  area_per_ray_m2_ = kPi * radius_m * radius_m / rays;
  samples_.reserve(static_cast<std::size_t>(rays));
  for (int i = 0; i < rays; ++i) {
    samples_.push_back(
        {radius_m * onDisc((i + 0.5) / rays, i * kGoldenAngle_rad),
         onDisc(fraction(i * kPlasticStep), 2.0 * kPi * fraction(i * kPlasticStepSquared))});
  }
}

void LightSpot::trace(const ConeTracer& tracer, const LuminousBall& light,
                      const RayVisitor& visit) const {
  const Vector2d sideways =
      light.radius_m * Vector2d(-light.position_m.y(), light.position_m.x()).normalized();
  for (const Sample& sample : samples_) {
    Vector3d source = light.position_m;
    source.head<2>() += sample.ball.x() * sideways;
    source.z() += sample.ball.y() * light.radius_m;
    if (const auto hit = tracer.rayFrom(source, sample.aperture_m)) {
      visit(hit->pixel, light.brightness * hit->throughput * area_per_ray_m2_);
    }
  }
}

SpotMoments LightSpot::moments(const ConeTracer& tracer, const LuminousBall& light) const {
  SpotMoments moments;
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
  const Vector2d origin = tracer.rig().centre_px;  // keeps the sums of squares small
  trace(tracer, light, [&](const Vector2d& pixel, double flux) {
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

void LightSpot::addTo(const ConeTracer& tracer, const LuminousBall& light,
                      double electrons_per_flux, std::vector<float>* electrons) const {
  const int width = tracer.rig().width_px;
  const int height = tracer.rig().height_px;
  const auto add = [&](int u, int v, double amount) {
    if (u < 0 || v < 0 || u >= width || v >= height) return;
    (*electrons)[static_cast<std::size_t>(v * width + u)] += static_cast<float>(amount);
  };
  trace(tracer, light, [&](const Vector2d& pixel, double flux) {
    const int u = static_cast<int>(std::floor(pixel.x()));
    const int v = static_cast<int>(std::floor(pixel.y()));
    const double right = pixel.x() - u;
    const double below = pixel.y() - v;
    const double amount = flux * electrons_per_flux;
    add(u, v, amount * (1.0 - right) * (1.0 - below));
    add(u + 1, v, amount * right * (1.0 - below));
    add(u, v + 1, amount * (1.0 - right) * below);
    add(u + 1, v + 1, amount * right * below);
  });
}

}  // namespace bearing_calibration
