#include "bearing_calibration/vision/spot_meter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/spot_sums.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// The background's ring lies outside the window, so far that it has about as many pixels.
constexpr double kRingBegin = 1.15;
constexpr double kRingEnd = 1.6;
constexpr int kMinRingPixels = 12;  // four for each coefficient of the plane
// Background and size are as good from some rows of a large spot as from all: at least so many of
// the window's.
constexpr double kEnoughRows = 10.0;

// In standard deviations of the spot: after a Newton step as small as this the next one is not
// worth its while (it goes with the square).
constexpr double kSmallStep = 0.03;

int rowStepFor(const PixelEllipse& window) {
  const double rows = 2.0 * window.size * std::sqrt(window.covariance_px2(1, 1));
  return std::max(1, static_cast<int>(rows / kEnoughRows));
}

/// Least squares over the ring around the window.
Background fitBackground(PlaneSums sums, const SpotLevels& levels) {
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

WeightPolynomial polynomialOf(const SpotWindow& window) {
  if (window.weight == CentreWeight::kEven) return {1.0F, 0.0F, 0.0F};
  const double size2 = window.size * window.size;
  return {0.0F, 1.0F, static_cast<float>(-1.0 / (size2 * size2))};
}

/// d sum(L w x) / d centre along an axis x.
double gainAlong(const Vector2d& axis, const CentreMoments& sums, const Matrix2d& information) {
  const Vector2d gradient = information * axis;
  return sums.weighted + 2.0 * axis.dot(sums.sloped_squares * gradient);
}

/// How far the light's centre lies from the window's, in one Newton step.
Vector2d shiftOf(const CentreMoments& sums, const Matrix2d& information, const MirrorAxes& axes) {
  Vector2d shift = Vector2d::Zero();
  for (const Vector2d& axis : {axes.radial, axes.tangential}) {
    shift += axis.dot(sums.moment) / gainAlong(axis, sums, information) * axis;
  }
  return shift;
}

/// What the last window says; `spread` of every row_step-th row.
SpotMeasurement measurementOf(const CentreMoments& centre, const SpreadMoments& spread,
                              int row_step, const SpotWindow& window, const MirrorAxes& axes) {
  // What the window alone says are integrals over its ellipse, in units of its variance along the
  // axis: pi sqrt(det) times those of w^2 m^3 and w m^3 from 0 to its size.
  const double scale = kPi * std::sqrt(window.covariance_px2.determinant());
  const double size4 = std::pow(window.size, 4);
  const bool even = window.weight == CentreWeight::kEven;
  const double pixel_squares = scale * size4 * (even ? 1.0 / 4.0 : size4 / 48.0);
  const double slope_lever = scale * size4 * (even ? 1.0 / 4.0 : window.size * window.size / 15.0);
  const Matrix2d information = window.covariance_px2.inverse();
  const auto along = [&](const Vector2d& axis) {
    const double window_variance_px2 = axis.dot(window.covariance_px2 * axis);
    AxisSums sums;
    sums.gain = gainAlong(axis, centre, information);
    sums.variance_px2 = axis.dot(spread.light_squares * axis) / spread.light;
    sums.light_noise = row_step * axis.dot(spread.noise_squares * axis);
    sums.pixel_squares = pixel_squares * window_variance_px2;
    sums.slope_lever = slope_lever * window_variance_px2;
    return sums;
  };
  SpotMeasurement spot;
  spot.mass_levels = centre.light;
  spot.peak_levels = spread.peak;
  spot.full_pixels = row_step * spread.full_pixels;
  spot.radial = along(axes.radial);
  spot.tangential = along(axes.tangential);
  spot.mixed_variance_px2 = axes.tangential.dot(spread.light_squares * axes.radial) / spread.light;
  const double squares = (information * spread.light_squares).trace();
  spot.kurtosis = spread.fourth_powers * spread.light / (squares * squares);
  return spot;
}

}  // namespace

std::optional<SpotMeasurement> measureSpot(const cv::Mat& image, const cv::Mat& sharp,
                                           const SpotWindow& first_window, const SpotLevels& levels,
                                           const Eigen::Vector2d& mirror_centre_px) {
  if (image.cols < kPixelLanes) return std::nullopt;  // no room for a light
  const WeightPolynomial weight = polynomialOf(first_window);
  const double reach_px = first_window.size * std::sqrt(first_window.covariance_px2.trace());
  SpotWindow window = first_window;
  const Matrix2d information = window.covariance_px2.inverse();
  const int row_step = rowStepFor(window);
  const PixelEllipse inside{window.centre_px, window.covariance_px2, kRingBegin * window.size};
  Background background = fitBackground(sumPlane(image, inside, kRingEnd * window.size, row_step,
                                                 levels.threshold, levels.background),
                                        levels);
  CentreMoments centre;
  Vector2d shift;
  const auto step = [&] {
    constexpr int kEveryRow = 1;
    centre = sumCentre(image, window, kEveryRow, weight, background.plane);
    shift = shiftOf(centre, information, MirrorAxes(window.centre_px, mirror_centre_px));
    return centre.light > 0.0 && shift.norm() < reach_px;
  };
  if (!step()) return std::nullopt;
  if (shift.dot(information * shift) > kSmallStep * kSmallStep) {
    background.plane.at_centre += background.plane.slope.dot(shift);
    window.centre_px += shift;
    if (!step()) return std::nullopt;
  }
  const SpreadMoments spread =
      sumSpread(image, sharp, window, row_step, weight, background.plane, levels.noise);
  if (!(spread.light > 0.0)) return std::nullopt;
  const MirrorAxes axes(window.centre_px, mirror_centre_px);
  SpotMeasurement spot = measurementOf(centre, spread, row_step, window, axes);
  spot.background = background;
  spot.background.plane.at_centre += background.plane.slope.dot(shift);
  spot.centre_px = window.centre_px + shift;
  return spot;
}

}  // namespace bearing_calibration::core
