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

/// Calls visit(row pointer, u, v, du, dv, squared Mahalanobis distance) for the pixels of the image
/// within `size` standard deviations.
template <typename Level, typename Visit>
void forEachPixel(const cv::Mat& image, const SpotWindow& window, double size, Visit visit) {
  const Matrix2d information = window.covariance_px2.inverse();
  const double half_width = size * std::sqrt(window.covariance_px2(0, 0));
  const double half_height = size * std::sqrt(window.covariance_px2(1, 1));
  const auto clampTo = [](double value, int last) {
    return static_cast<int>(std::clamp(value, -1.0, last + 1.0));
  };
  const double u0 = window.centre_px.x();
  const double v0 = window.centre_px.y();
  const int first_u = std::max(0, clampTo(std::ceil(u0 - half_width), image.cols));
  const int last_u = std::min(image.cols - 1, clampTo(std::floor(u0 + half_width), image.cols));
  const int first_v = std::max(0, clampTo(std::ceil(v0 - half_height), image.rows));
  const int last_v = std::min(image.rows - 1, clampTo(std::floor(v0 + half_height), image.rows));
  for (int v = first_v; v <= last_v; ++v) {
    const Level* row = image.ptr<Level>(v);
    const double dv = v - v0;
    const double square = information(1, 1) * dv * dv;
    for (int u = first_u; u <= last_u; ++u) {
      const double du = u - u0;
      const double distance2 =
          square + du * (information(0, 0) * du + 2.0 * information(0, 1) * dv);
      if (distance2 <= size * size) visit(row[u], u, v, du, dv, distance2);
    }
  }
}

/// Least squares over the ring around the window.
template <typename Level>
BackgroundPlane fitBackground(const cv::Mat& image, const SpotWindow& window,
                              const SpotLevels& levels) {
  const double begin2 = std::pow(kRingBegin * window.size, 2);
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  double sum_of_squares = 0.0;
  forEachPixel<Level>(image, window, kRingEnd * window.size,
                      [&](Level level, int, int, double du, double dv, double distance2) {
                        if (distance2 < begin2 || level > levels.threshold) return;
                        const Vector3d row(1.0, du, dv);
                        normal.noalias() += row * row.transpose();
                        right.noalias() += level * row;
                        sum_of_squares += static_cast<double>(level) * level;
                      });
  const double pixels = normal(0, 0);
  BackgroundPlane plane;
  if (pixels < kMinRingPixels) {
    plane.at_centre = levels.background;
    return plane;
  }
  constexpr double kRidge_px2 = 1e-6;  // pixels in one line leave the slope across it at zero
  normal(1, 1) += kRidge_px2;
  normal(2, 2) += kRidge_px2;
  const Vector3d solution = normal.ldlt().solve(right);
  plane.at_centre = solution(0);
  plane.slope = solution.tail<2>();
  plane.residual_variance =
      std::max(0.0, sum_of_squares - solution.dot(right)) / (pixels - solution.size());
  plane.sum_of_squares = 0.5 * (normal(1, 1) + normal(2, 2));
  return plane;
}

/// Mass and first moments over the background, relative to the window's centre.
template <typename Level>
Vector3d firstMoments(const cv::Mat& image, const SpotWindow& window,
                      const BackgroundPlane& background) {
  Vector3d moments = Vector3d::Zero();
  forEachPixel<Level>(
      image, window, window.size, [&](Level level, int, int, double du, double dv, double) {
        const double light =
            level - background.at_centre - background.slope.x() * du - background.slope.y() * dv;
        moments += light * Vector3d(1.0, du, dv);
      });
  return moments;
}

void addTo(AxisSums* sums, double x, double level, double light, bool full) {
  const double x2 = x * x;
  sums->variance_px2 += light * x2;
  sums->pixel_squares += x2;
  sums->intensity_squares += light * light * x2;
  if (!full) sums->light_squares += level * x2;
}

/// Second moments and the sums of the variances about `measurement->centre_px`.
template <typename Level>
void secondMoments(const cv::Mat& image, const cv::Mat& sharp, const SpotWindow& window,
                   const SpotLevels& levels, const Vector2d& radial, const Vector2d& tangential,
                   SpotMeasurement* measurement) {
  const Vector2d shift = measurement->centre_px - window.centre_px;
  const BackgroundPlane& plane = measurement->background;
  forEachPixel<Level>(
      image, window, window.size, [&](Level level, int u, int v, double du, double dv, double) {
        const double light = level - plane.at_centre - plane.slope.x() * du - plane.slope.y() * dv;
        const Vector2d d(du - shift.x(), dv - shift.y());
        const double t = d.dot(tangential);
        const double r = d.dot(radial);
        const bool full = sharp.ptr<Level>(v)[u] >= levels.saturation;
        const double lit = std::max(0.0, level - levels.black);
        addTo(&measurement->tangential, t, lit, light, full);
        addTo(&measurement->radial, r, lit, light, full);
        measurement->mixed_variance_px2 += light * t * r;
        measurement->full_pixels += full ? 1 : 0;
        measurement->peak_levels = std::max<double>(measurement->peak_levels, level);
      });
  measurement->tangential.variance_px2 /= measurement->mass_levels;
  measurement->radial.variance_px2 /= measurement->mass_levels;
  measurement->mixed_variance_px2 /= measurement->mass_levels;
}

template <typename Level>
std::optional<SpotMeasurement> measure(const cv::Mat& image, const cv::Mat& sharp,
                                       SpotWindow window, const SpotLevels& levels,
                                       const Vector2d& mirror_centre_px, int handedness) {
  constexpr int kPasses = 2;
  SpotMeasurement measurement;
  for (int pass = 0; pass < kPasses; ++pass) {
    if (pass > 0) window.centre_px = measurement.centre_px;
    measurement.background = fitBackground<Level>(image, window, levels);
    const Vector3d moments = firstMoments<Level>(image, window, measurement.background);
    measurement.mass_levels = moments(0);
    const Vector2d shift = moments.tail<2>() / moments(0);
    const double reach = window.size * std::sqrt(window.covariance_px2.trace());
    if (!(moments(0) > 0.0 && shift.norm() < reach)) return std::nullopt;
    measurement.centre_px = window.centre_px + shift;
  }
  const Vector2d radial = (measurement.centre_px - mirror_centre_px).normalized();
  // On the screen v grows downwards: counter-clockwise is (v, -u).
  const Vector2d tangential = handedness * Vector2d(radial.y(), -radial.x());
  secondMoments<Level>(image, sharp, window, levels, radial, tangential, &measurement);
  return measurement;
}

}  // namespace

std::optional<SpotMeasurement> measureSpot(const cv::Mat& image, const cv::Mat& sharp,
                                           const SpotWindow& window, const SpotLevels& levels,
                                           const Vector2d& mirror_centre_px, int handedness) {
  if (image.depth() == CV_8U) {
    return measure<std::uint8_t>(image, sharp, window, levels, mirror_centre_px, handedness);
  }
  return measure<std::uint16_t>(image, sharp, window, levels, mirror_centre_px, handedness);
}

}  // namespace bearing_calibration
