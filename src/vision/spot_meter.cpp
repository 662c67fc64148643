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

/// The weight of a pixel at `d` from the centre, and its gradient.
class Weighting {
 public:
  explicit Weighting(const SpotWindow& window)
      : even_(window.weight == CentreWeight::kEven),
        size2_(window.size * window.size),
        information_(window.covariance_px2.inverse()) {}

  double at(const Vector2d& d) const {
    if (even_) return 1.0;
    const double distance2 = d.dot(information_ * d);
    return distance2 * (1.0 - std::pow(distance2 / size2_, 2));
  }
  Vector2d gradient(const Vector2d& d) const {
    if (even_) return Vector2d::Zero();
    const Vector2d direction = information_ * d;
    return 2.0 * (1.0 - 3.0 * std::pow(d.dot(direction) / size2_, 2)) * direction;
  }

 private:
  bool even_;
  double size2_;
  Matrix2d information_;
};

/// One Newton step for the centre, and the light's mass.
struct CentreStep {
  double mass_levels = 0.0;
  Vector2d shift = Vector2d::Zero();
};

template <typename Level>
CentreStep stepToCentre(const cv::Mat& image, const SpotWindow& window,
                        const BackgroundPlane& background) {
  const Weighting weighting(window);
  CentreStep step;
  Vector2d sum = Vector2d::Zero();
  Matrix2d gain = Matrix2d::Zero();
  forEachPixel<Level>(
      image, window, window.size, [&](Level level, int, int, double du, double dv, double) {
        const Vector2d d(du, dv);
        const double light = level - background.at_centre - background.slope.dot(d);
        const double weight = weighting.at(d);
        step.mass_levels += light;
        sum += light * weight * d;
        gain += light * (weight * Matrix2d::Identity() + d * weighting.gradient(d).transpose());
      });
  step.shift = gain.inverse() * sum;
  return step;
}

/// What a pixel at `d` from the centre adds along the unit vector `axis`.
void addTo(AxisSums* sums, const Weighting& weighting, const Vector2d& axis, const Vector2d& d,
           double lit, double light) {
  const double x = d.dot(axis);
  const double weight = weighting.at(d);
  const double phi = weight * x;
  sums->variance_px2 += light * x * x;
  sums->gain += light * (weight + x * weighting.gradient(d).dot(axis));
  sums->light_squares += lit * phi * phi;
  sums->pixel_squares += phi * phi;
  sums->intensity_squares += light * light * phi * phi;
  sums->slope_lever += x * phi;
}

/// Second moments and the sums of the variances about `measurement->centre_px`.
template <typename Level>
void addMoments(const cv::Mat& image, const cv::Mat& sharp, const SpotWindow& window,
                const SpotLevels& levels, const Vector2d& radial, const Vector2d& tangential,
                SpotMeasurement* measurement) {
  const Weighting weighting(window);
  const Vector2d shift = measurement->centre_px - window.centre_px;
  const BackgroundPlane& plane = measurement->background;
  forEachPixel<Level>(
      image, window, window.size, [&](Level level, int u, int v, double du, double dv, double) {
        const double light = level - plane.at_centre - plane.slope.dot(Vector2d(du, dv));
        const Vector2d d = Vector2d(du, dv) - shift;
        const bool full = sharp.ptr<Level>(v)[u] >= levels.saturation;
        const double lit = full ? 0.0 : std::max(0.0, level - levels.black);
        addTo(&measurement->tangential, weighting, tangential, d, lit, light);
        addTo(&measurement->radial, weighting, radial, d, lit, light);
        measurement->mixed_variance_px2 += light * d.dot(tangential) * d.dot(radial);
        measurement->full_pixels += full ? 1 : 0;
        measurement->peak_levels = std::max<double>(measurement->peak_levels, level);
      });
  measurement->tangential.variance_px2 /= measurement->mass_levels;
  measurement->radial.variance_px2 /= measurement->mass_levels;
  measurement->mixed_variance_px2 /= measurement->mass_levels;
}

template <typename Level>
std::optional<SpotMeasurement> measure(const cv::Mat& image, const cv::Mat& sharp,
                                       const SpotWindow& first_window, const SpotLevels& levels,
                                       const Vector2d& mirror_centre_px, int handedness) {
  constexpr int kPasses = 3;  // the centroid, and two Newton steps from it
  const double reach = first_window.size * std::sqrt(first_window.covariance_px2.trace());
  SpotWindow window = first_window;
  SpotMeasurement measurement;
  measurement.centre_px = window.centre_px;
  for (int pass = 0; pass < kPasses; ++pass) {
    window.centre_px = measurement.centre_px;
    window.weight = pass == 0 ? CentreWeight::kEven : first_window.weight;
    measurement.background = fitBackground<Level>(image, window, levels);
    const CentreStep step = stepToCentre<Level>(image, window, measurement.background);
    measurement.mass_levels = step.mass_levels;
    if (!(step.mass_levels > 0.0 && step.shift.norm() < reach)) return std::nullopt;
    measurement.centre_px += step.shift;
  }
  const Vector2d radial = (measurement.centre_px - mirror_centre_px).normalized();
  // On the screen v grows downwards: counter-clockwise is (v, -u).
  const Vector2d tangential = handedness * Vector2d(radial.y(), -radial.x());
  addMoments<Level>(image, sharp, window, levels, radial, tangential, &measurement);
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
