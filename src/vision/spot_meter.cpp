#include "bearing_calibration/vision/spot_meter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace bearing_calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The background's ring lies outside the window, so far that it has about as many pixels.
constexpr double kRingBegin = 1.15;
constexpr double kRingEnd = 1.6;
constexpr int kMinRingPixels = 12;  // four for each coefficient of the plane

/// Calls visit(level, u, v, du, dv, squared Mahalanobis distance) for the pixels of the image
/// within `size` standard deviations of the window's centre.
template <typename Level, typename Visit>
void forEachPixel(const cv::Mat& image, const SpotWindow& window, double size, Visit visit) {
  const Matrix2d information = window.covariance_px2.inverse();
  const double uu = information(0, 0);
  const double uv = information(0, 1);
  const double vv = information(1, 1);
  const double u0 = window.centre_px.x();
  const double v0 = window.centre_px.y();
  const auto within = [](double value, int last) {
    return static_cast<int>(std::clamp(value, -1.0, last + 1.0));
  };
  const double half_height = size * std::sqrt(window.covariance_px2(1, 1));
  const int first_v = std::max(0, within(std::ceil(v0 - half_height), image.rows));
  const int last_v = std::min(image.rows - 1, within(std::floor(v0 + half_height), image.rows));
  for (int v = first_v; v <= last_v; ++v) {
    const Level* row = image.ptr<Level>(v);
    const double dv = v - v0;
    // uu du^2 + 2 uv du dv + vv dv^2 <= size^2
    const double middle = u0 - uv * dv / uu;
    const double reach2 = (size * size - (vv - uv * uv / uu) * dv * dv) / uu;
    const double reach = std::sqrt(std::max(0.0, reach2));
    const int first_u = std::max(0, within(std::ceil(middle - reach), image.cols));
    const int last_u = std::min(image.cols - 1, within(std::floor(middle + reach), image.cols));
    for (int u = first_u; u <= last_u; ++u) {
      const double du = u - u0;
      visit(row[u], u, v, du, dv, uu * du * du + 2.0 * uv * du * dv + vv * dv * dv);
    }
  }
}

/// Least squares over the ring around the window.
template <typename Level>
BackgroundPlane fitBackground(const cv::Mat& image, const SpotWindow& window,
                              const SpotLevels& levels) {
  const double begin2 = std::pow(kRingBegin * window.size, 2);
  double pixels = 0.0, u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;
  double light = 0.0, light_u = 0.0, light_v = 0.0, light2 = 0.0;
  forEachPixel<Level>(image, window, kRingEnd * window.size,
                      [&](Level raw, int, int, double du, double dv, double distance2) {
                        const double level = raw;
                        if (distance2 < begin2 || level > levels.threshold) return;
                        pixels += 1.0;
                        u += du;
                        v += dv;
                        uu += du * du;
                        uv += du * dv;
                        vv += dv * dv;
                        light += level;
                        light_u += level * du;
                        light_v += level * dv;
                        light2 += level * level;
                      });
  BackgroundPlane plane;
  if (pixels < kMinRingPixels) {
    plane.at_centre = levels.background;
    return plane;
  }
  constexpr double kRidge_px2 = 1e-6;  // pixels in one line leave the slope across it at zero
  const Matrix3d normal =
      (Matrix3d() << pixels, u, v, u, uu + kRidge_px2, uv, v, uv, vv + kRidge_px2).finished();
  const Vector3d right(light, light_u, light_v);
  const Vector3d solution = normal.ldlt().solve(right);
  plane.at_centre = solution(0);
  plane.slope = solution.tail<2>();
  plane.residual_variance =
      std::max(0.0, light2 - solution.dot(right)) / (pixels - solution.size());
  plane.sum_of_squares = 0.5 * (uu + vv);
  return plane;
}

/// Unit vectors at a place in the image, along the mirror's radius and across it.
struct MirrorAxes {
  MirrorAxes(const Vector2d& place_px, const Vector2d& mirror_centre_px)
      : radial((place_px - mirror_centre_px).normalized()), tangential(-radial.y(), radial.x()) {}

  Vector2d radial;
  Vector2d tangential;
};

/// The weight of a pixel at the squared Mahalanobis distance m^2 from the window's centre, and its
/// derivative over m^2.
struct Weight {
  double value;
  double slope;
};
Weight weightAt(const SpotWindow& window, double distance2) {
  if (window.weight == CentreWeight::kEven) return {1.0, 0.0};
  const double part = distance2 / (window.size * window.size);
  return {distance2 * (1.0 - part * part), 1.0 - 3.0 * part * part};
}

/// A pixel's part of the sums along x; `gradient` is the weight's along x.
void addPixel(AxisSums* sums, double x, const Weight& weight, double gradient, double lit,
              double light) {
  const double phi = weight.value * x;
  const double phi2 = phi * phi;
  sums->light_moment += light * phi;
  sums->gain += light * (weight.value + x * gradient);
  sums->variance_px2 += light * x * x;
  sums->light_squares += lit * phi2;
  sums->pixel_squares += phi2;
  sums->intensity_squares += light * light * phi2;
  sums->slope_lever += x * phi;
}

/// How far the light's centre lies from the window's, in one Newton step; nothing without light.
template <typename Level>
std::optional<Vector2d> shiftOf(const cv::Mat& image, const SpotWindow& window,
                                const BackgroundPlane& plane, const MirrorAxes& axes) {
  const Matrix2d information = window.covariance_px2.inverse();
  const Vector2d to_gradient_r = 2.0 * information * axes.radial;
  const Vector2d to_gradient_t = 2.0 * information * axes.tangential;
  double mass = 0.0, moment_r = 0.0, moment_t = 0.0, gain_r = 0.0, gain_t = 0.0;
  forEachPixel<Level>(
      image, window, window.size, [&](Level raw, int, int, double du, double dv, double distance2) {
        const double light = raw - plane.at_centre - plane.slope.x() * du - plane.slope.y() * dv;
        const Weight weight = weightAt(window, distance2);
        const double r = axes.radial.x() * du + axes.radial.y() * dv;
        const double t = axes.tangential.x() * du + axes.tangential.y() * dv;
        const double weighted = light * weight.value;
        const double sloped = light * weight.slope;
        mass += light;
        moment_r += weighted * r;
        moment_t += weighted * t;
        gain_r += weighted + sloped * r * (to_gradient_r.x() * du + to_gradient_r.y() * dv);
        gain_t += weighted + sloped * t * (to_gradient_t.x() * du + to_gradient_t.y() * dv);
      });
  if (!(mass > 0.0)) return std::nullopt;
  return moment_r / gain_r * axes.radial + moment_t / gain_t * axes.tangential;
}

/// All sums over a window, along the mirror's radius and tangent at its centre.
template <typename Level>
SpotMeasurement sumUp(const cv::Mat& image, const cv::Mat& sharp, const SpotWindow& window,
                      const SpotLevels& levels, const BackgroundPlane& plane,
                      const MirrorAxes& axes) {
  const Vector2d& radial = axes.radial;
  const Vector2d& tangential = axes.tangential;
  SpotMeasurement spot;
  double squares = 0.0, fourth_powers = 0.0;
  spot.centre_px = window.centre_px;
  spot.background = plane;
  const Matrix2d information = window.covariance_px2.inverse();
  const Vector2d to_gradient_r = 2.0 * information * radial;
  const Vector2d to_gradient_t = 2.0 * information * tangential;
  forEachPixel<Level>(
      image, window, window.size,
      [&](Level raw, int u, int v, double du, double dv, double distance2) {
        const double level = raw;
        const double light = level - plane.at_centre - plane.slope.x() * du - plane.slope.y() * dv;
        const double r = radial.x() * du + radial.y() * dv;
        const double t = tangential.x() * du + tangential.y() * dv;
        const bool full = sharp.ptr<Level>(v)[u] >= levels.saturation;
        const double lit = full ? 0.0 : std::max(0.0, level - levels.black);
        const Weight weight = weightAt(window, distance2);
        addPixel(&spot.radial, r, weight,
                 weight.slope * (to_gradient_r.x() * du + to_gradient_r.y() * dv), lit, light);
        addPixel(&spot.tangential, t, weight,
                 weight.slope * (to_gradient_t.x() * du + to_gradient_t.y() * dv), lit, light);
        spot.mass_levels += light;
        squares += light * distance2;
        fourth_powers += light * distance2 * distance2;
        spot.mixed_variance_px2 += light * t * r;
        spot.full_pixels += full ? 1 : 0;
        spot.peak_levels = std::max(spot.peak_levels, level);
      });
  spot.radial.variance_px2 /= spot.mass_levels;
  spot.tangential.variance_px2 /= spot.mass_levels;
  spot.mixed_variance_px2 /= spot.mass_levels;
  spot.peakedness = fourth_powers * spot.mass_levels / (squares * squares);
  return spot;
}

template <typename Level>
std::optional<SpotMeasurement> measure(const cv::Mat& image, const cv::Mat& sharp,
                                       const SpotWindow& first_window, const SpotLevels& levels,
                                       const Vector2d& mirror_centre_px) {
  const double reach_px = first_window.size * std::sqrt(first_window.covariance_px2.trace());
  SpotWindow window = first_window;
  BackgroundPlane plane = fitBackground<Level>(image, window, levels);
  // From the thresholded pixels' centre, some tenths of a pixel away.
  const std::optional<Vector2d> shift =
      shiftOf<Level>(image, window, plane, MirrorAxes(window.centre_px, mirror_centre_px));
  if (!shift || !(shift->norm() < reach_px)) return std::nullopt;
  plane.at_centre += plane.slope.dot(*shift);
  window.centre_px += *shift;
  const MirrorAxes axes(window.centre_px, mirror_centre_px);
  SpotMeasurement spot = sumUp<Level>(image, sharp, window, levels, plane, axes);
  const Vector2d last_shift = spot.radial.light_moment / spot.radial.gain * axes.radial +
                              spot.tangential.light_moment / spot.tangential.gain * axes.tangential;
  if (!(spot.mass_levels > 0.0 && last_shift.norm() < reach_px)) return std::nullopt;
  spot.background.at_centre += plane.slope.dot(last_shift);
  spot.centre_px += last_shift;
  return spot;
}

}  // namespace

std::optional<SpotMeasurement> measureSpot(const cv::Mat& image, const cv::Mat& sharp,
                                           const SpotWindow& window, const SpotLevels& levels,
                                           const Vector2d& mirror_centre_px) {
  if (image.depth() == CV_8U) {
    return measure<std::uint8_t>(image, sharp, window, levels, mirror_centre_px);
  }
  return measure<std::uint16_t>(image, sharp, window, levels, mirror_centre_px);
}

}  // namespace bearing_calibration
