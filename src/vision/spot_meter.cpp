#include "bearing_calibration/vision/spot_meter.h"

#include <Eigen/Dense>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The background's ring lies outside the window, so far that it has about as many pixels.
constexpr double kRingBegin = 1.15;
constexpr double kRingEnd = 1.6;
constexpr int kMinRingPixels = 12;  // four for each coefficient of the plane

/// Least squares over the ring around the window.
Background fitBackground(const PixelColumn& ring, const SpotLevels& levels) {
  PlaneSums sums = sumPlane(ring, levels.threshold, levels.background);
  const double pixels = sums.normal(0, 0);
  Background background;
  background.plane.at_centre = levels.background;
  if (pixels < kMinRingPixels) return background;
  background.sum_of_squares = 0.5 * (sums.normal(1, 1) + sums.normal(2, 2));
  constexpr double kRidge_px2 = 1e-6;  // pixels in one line leave the slope across it at zero
  sums.normal(1, 1) += kRidge_px2;
  sums.normal(2, 2) += kRidge_px2;
  const Vector3d solution = sums.normal.inverse() * sums.right;
  background.plane.at_centre += solution(0);
  background.plane.slope = solution.tail<2>();
  background.residual_variance =
      std::max(0.0, sums.squares - solution.dot(sums.right)) / (pixels - solution.size());
  return background;
}

/// Unit vectors at a place in the image, along the mirror's radius and across it.
struct MirrorAxes {
  MirrorAxes(const Vector2d& place_px, const Vector2d& mirror_centre_px)
      : radial((place_px - mirror_centre_px).normalized()), tangential(-radial.y(), radial.x()) {}

  Vector2d radial;
  Vector2d tangential;
};

WeightPolynomial polynomialOf(const SpotWindow& window) {
  if (window.weight == CentreWeight::kEven) return {1.0, 0.0, 0.0};
  const double size2 = window.size * window.size;
  return {0.0, 1.0, -1.0 / (size2 * size2)};
}

/// d sum(L w x) / d centre along an axis x.
double gainAlong(const Vector2d& axis, const WindowSums& sums, const Matrix2d& information) {
  const Vector2d gradient = information * axis;
  return sums.weighted + 2.0 * axis.dot(sums.sloped_squares * gradient);
}

/// What the window alone says: sums over its pixels as integrals over its ellipse, in units of its
/// variance along the axis.
struct WindowIntegrals {
  explicit WindowIntegrals(const SpotWindow& window) {
    // pi sqrt(det) times the integrals of w^2 m^3 and w m^3 from 0 to M
    const double scale = kPi * std::sqrt(window.covariance_px2.determinant());
    const double size2 = window.size * window.size;
    if (window.weight == CentreWeight::kEven) {
      pixel_squares = slope_lever = scale * size2 * size2 / 4.0;
    } else {
      pixel_squares = scale * size2 * size2 * size2 * size2 / 48.0;
      slope_lever = scale * size2 * size2 * size2 / 15.0;
    }
  }

  double pixel_squares;
  double slope_lever;
};

/// How far the light's centre lies from the window's, in one Newton step.
Vector2d shiftOf(const WindowSums& sums, const Matrix2d& information, const MirrorAxes& axes) {
  Vector2d shift = Vector2d::Zero();
  for (const Vector2d& axis : {axes.radial, axes.tangential}) {
    shift += axis.dot(sums.moment) / gainAlong(axis, sums, information) * axis;
  }
  return shift;
}

AxisSums alongAxis(const Vector2d& axis, const WindowSums& sums, const SpotWindow& window,
                   const Matrix2d& information) {
  const WindowIntegrals integrals(window);
  const double window_variance_px2 = axis.dot(window.covariance_px2 * axis);
  AxisSums along;
  along.gain = gainAlong(axis, sums, information);
  along.variance_px2 = axis.dot(sums.light_squares * axis) / sums.light;
  along.light_noise = axis.dot(sums.noise_squares * axis);
  along.pixel_squares = integrals.pixel_squares * window_variance_px2;
  along.slope_lever = integrals.slope_lever * window_variance_px2;
  return along;
}

SpotMeasurement measurementOf(const WindowSums& sums, const SpotWindow& window,
                              const Matrix2d& information, const MirrorAxes& axes) {
  SpotMeasurement spot;
  spot.mass_levels = sums.light;
  spot.peak_levels = sums.peak;
  spot.full_pixels = sums.full_pixels;
  spot.radial = alongAxis(axes.radial, sums, window, information);
  spot.tangential = alongAxis(axes.tangential, sums, window, information);
  spot.mixed_variance_px2 = axes.tangential.dot(sums.light_squares * axes.radial) / sums.light;
  const double squares = (information * sums.light_squares).trace();
  spot.peakedness = sums.fourth_powers * sums.light / (squares * squares);
  return spot;
}

}  // namespace

std::optional<SpotMeasurement> SpotMeter::measure(const cv::Mat& image, const cv::Mat& sharp,
                                                  const SpotWindow& first_window,
                                                  const SpotLevels& levels,
                                                  const Eigen::Vector2d& mirror_centre_px) {
  const WeightPolynomial weight = polynomialOf(first_window);
  const Matrix2d& covariance = first_window.covariance_px2;
  const Matrix2d information = covariance.inverse();
  const double size = first_window.size;
  const double reach_px = size * std::sqrt(covariance.trace());
  const auto gatherAround = [&](const Vector2d& centre_px) {
    pixels_.gather(image, sharp, {centre_px, covariance, kRingEnd * size}, kRingBegin * size);
  };
  gatherAround(first_window.centre_px);
  Background background = fitBackground(pixels_.ring(), levels);
  // From the thresholded pixels' centre, some tenths of a pixel away.
  PixelEllipse ellipse{Vector2d::Zero(), covariance, size};
  WindowSums sums = sumCentre(pixels_.window(), ellipse, weight, background.plane);
  const Vector2d first_shift =
      shiftOf(sums, information, MirrorAxes(first_window.centre_px, mirror_centre_px));
  if (!(sums.light > 0.0 && first_shift.norm() < reach_px)) return std::nullopt;
  background.plane.at_centre += background.plane.slope.dot(first_shift);
  const Vector2d centre_px = first_window.centre_px + first_shift;
  const bool inside =
      std::sqrt(first_shift.dot(information * first_shift)) <= (kRingBegin - 1.0) * size;
  if (inside) {
    ellipse.centre_px = first_shift;
  } else {
    gatherAround(centre_px);
  }
  const MirrorAxes axes(centre_px, mirror_centre_px);
  sums = sumWindow(pixels_.window(), pixels_.sensed(), ellipse, weight, background.plane,
                   levels.noise);
  const Vector2d last_shift = shiftOf(sums, information, axes);
  if (!(sums.light > 0.0 && last_shift.norm() < reach_px)) return std::nullopt;
  SpotMeasurement spot = measurementOf(sums, first_window, information, axes);
  spot.background = background;
  spot.background.plane.at_centre += background.plane.slope.dot(last_shift);
  spot.centre_px = centre_px + last_shift;
  return spot;
}

}  // namespace bearing_calibration
