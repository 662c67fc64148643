#include "bearing_calibration/vision/spot_meter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Array2d;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// An evenly filled ellipse ends at two standard deviations; the window leaves room for the pixels'
// size. A Gaussian goes on further, and a spot of a pixel's width needs room for its pixels.
constexpr double kDiscWindow = 2.5;
constexpr double kGaussianWindow = 3.2;
constexpr double kMargin_px = 1.0;
// A disc has an inside when it is some pixels wide.
constexpr double kLeastDiscStddev_px = 1.5;

// The background's ring lies outside the window, so far that it has about as many pixels.
constexpr double kRingBegin = 1.15;
constexpr double kRingEnd = 1.6;
constexpr int kMinRingPixels = 12;  // four for each coefficient of the plane
// Background and size are as good from some rows of a large spot as from all: at least so many of
// the window's.
constexpr double kEnoughRows = 10.0;

constexpr double kRoundingVariance = 1.0 / 12.0;  // of a level rounded to an integer
// Neighbouring pixels of a background's texture vary together, over patches of about 3 x 3.
constexpr double kTexturePatch_px = 9.0;

/// Read noise and rounding of one pixel [levels^2].
double readVariance(const ImageSensor& sensor) {
  return std::pow(sensor.read_noise_electrons / sensor.electrons_per_level, 2) + kRoundingVariance;
}

int rowStepFor(const PixelEllipse& window) {
  const double rows = 2.0 * window.size * std::sqrt(window.covariance_px2(1, 1));
  return std::max(1, static_cast<int>(rows / kEnoughRows));
}

/// The background under a spot.
struct Background {
  LevelPlane plane;
  double residual_variance = 0.0;  ///< of the ring's pixels about the plane [levels^2]
  /// Of the slope, in parts of the ring's pixels' variance [1 / px^2].
  Matrix2d slope_covariance_px2inv = Matrix2d::Zero();
};

/// Least squares over the ring around the window; a level without enough of its pixels.
Background fitBackground(PlaneSums sums, double level) {
  const double pixels = sums.normal(0, 0);
  Background background;
  background.plane.at_centre = level;
  if (pixels < kMinRingPixels) return background;
  constexpr double kRidge_px2 = 1e-6;  // pixels in one line leave the slope across it at zero
  sums.normal(1, 1) += kRidge_px2;
  sums.normal(2, 2) += kRidge_px2;
  const Matrix3d covariance = sums.normal.inverse();
  const Vector3d solution = covariance * sums.right;
  background.plane.at_centre += solution(0);
  background.plane.slope = solution.tail<2>();
  background.slope_covariance_px2inv = covariance.bottomRightCorner<2, 2>();
  background.residual_variance =
      std::max(0.0, sums.squares - solution.dot(sums.right)) / (pixels - solution.size());
  return background;
}

WeightPolynomial polynomialOf(const SpotWindow& window) {
  if (!window.by_outline) return {1.0F, 0.0F, 0.0F};
  const double size2 = window.size * window.size;
  return {0.0F, 1.0F, static_cast<float>(-1.0 / (size2 * size2))};
}

/// After a Newton step that is small the next one is not worth its while (it goes with the square).
bool isLong(const Vector2d& step_px, const PixelEllipse& window) {
  constexpr double kSmallStep = 0.03;  // in standard deviations of the spot
  return step_px.dot(window.covariance_px2.inverse() * step_px) > kSmallStep * kSmallStep;
}

/// One Newton step from a window's centre to the light's.
struct CentreStep {
  CentreMoments sums;
  Matrix2d axes;
  Vector2d gain;  ///< d sum(L w x) / d centre along each axis x
  Vector2d shift_px;
};

/// @return nothing when the window holds no light, or the step leaves it
std::optional<CentreStep> stepFrom(const cv::Mat& levels, const SpotWindow& window,
                                   const LevelPlane& background, const Vector2d& mirror_centre_px) {
  constexpr int kEveryRow = 1;
  const Matrix2d information = window.covariance_px2.inverse();
  CentreStep step;
  step.sums = sumCentre(levels, window, kEveryRow, polynomialOf(window), background);
  step.axes = mirrorAxes(window.centre_px, mirror_centre_px);
  step.gain = step.sums.weighted +
              2.0 * diagonalAlong(step.axes, step.sums.sloped_squares * information).array();
  const Vector2d moment = step.axes.transpose() * step.sums.moment;
  step.shift_px = step.axes * moment.cwiseQuotient(step.gain);
  const double reach_px = window.size * std::sqrt(window.covariance_px2.trace());
  const bool inside = step.sums.light > 0.0 && step.shift_px.norm() < reach_px;
  return inside ? std::optional<CentreStep>(step) : std::nullopt;
}

/// Variance of the ring's pixels beyond their noise [levels^2].
double textureVariance(const DetectorConfig& config, const Background& background) {
  const ImageSensor& sensor = config.sensor;
  const double light = std::max(0.0, background.plane.at_centre - sensor.black_level);
  const double noise = light / sensor.electrons_per_level + readVariance(sensor);
  // A Gaussian blur leaves this part of the white noise's variance in each pixel.
  const double part_left = 1.0 / (1.0 + 4.0 * kPi * std::pow(config.defocus_sigma_px, 2));
  return std::max(0.0, background.residual_variance - noise * part_left);
}

/// Of the centre, for the noise of the pixels and what lies behind the light [px^2]. With w the
/// weights and x the axes, noise e of the pixels moves the centre by sum(e w x) / gain.
/// @param light_squares  sum(N w^2 x^2), N the noise that grows with the light [levels^2]
Vector2d noiseOf(const CentreStep& step, const SpotWindow& window, const Array2d& light_squares,
                 const Background& background, const DetectorConfig& config) {
  // What the window alone says are integrals over its ellipse, in units of its variance along the
  // axis: pi sqrt(det) times those of w^2 m^3 and w m^3 from 0 to its size.
  const double size2 = window.size * window.size;
  const double size4 = size2 * size2;
  const Array2d scale = kPi * std::sqrt(window.covariance_px2.determinant()) * size4 *
                        diagonalAlong(step.axes, window.covariance_px2);
  const Array2d squares = scale * (window.by_outline ? size4 / 48.0 : 1.0 / 4.0);  // sum(w^2 x^2)
  const Array2d lever = scale * (window.by_outline ? size2 / 15.0 : 1.0 / 4.0);    // sum(w x^2)
  const double of_texture = textureVariance(config, background);
  const double texture = of_texture * kTexturePatch_px;
  // The ring has every so many rows of a patch, one at least: so many pixels vary together.
  const double together_px = std::max(3.0, kTexturePatch_px / rowStepFor(window));
  const Array2d slope_variance = (background.residual_variance + (together_px - 1.0) * of_texture) *
                                 diagonalAlong(step.axes, background.slope_covariance_px2inv);
  return (light_squares + (readVariance(config.sensor) + texture) * squares +
          slope_variance * lever.square()) /
         step.gain.array().square();
}

/// What its pixels say of the light's size and shape.
void takeSpread(const SpreadMoments& spread, const SpotWindow& window, const Matrix2d& axes,
                LightEllipse* light) {
  light->moments_px2 = axes.transpose() * spread.light_squares * axes / spread.light;
  light->peak_levels = spread.peak;
  if (!window.by_outline) return;
  const double squares = (window.covariance_px2.inverse() * spread.light_squares).trace();
  light->kurtosis = spread.fourth_powers * spread.light / (squares * squares);
}

}  // namespace

SpotWindow windowFor(const LightEllipse& thresholded, const ExpectedSpot* expected,
                     const DetectorConfig& config) {
  const Matrix2d axes = mirrorAxes(thresholded.centre_px, config.view.centre_px());
  SpotWindow window;
  window.centre_px = thresholded.centre_px;
  window.size = kGaussianWindow;
  if (expected == nullptr) {
    window.covariance_px2 = axes * thresholded.moments_px2 * axes.transpose();
    return window;
  }
  constexpr double kByThreshold = 1.03;  // a bright spot gains a pixel all round
  const SpotSize& size = expected->at(thresholded.centre_px);
  const Array2d least_px = size.least_stddev_px;
  const Array2d most_px = size.most_stddev_px;
  const Array2d widening = size.widening();
  const Array2d seen_px = thresholded.variances_px2().cwiseSqrt();
  const Array2d usual_px = seen_px.max(least_px).min(most_px);
  const Array2d near_px = usual_px.max(seen_px / kByThreshold).min(seen_px * kByThreshold);
  Array2d stddev_px = near_px.max(least_px / widening).min(most_px * widening);
  // What the lens defocuses is an evenly filled ellipse; all else is taken for a Gaussian.
  if (config.defocus_sigma_px == 0.0 && stddev_px.minCoeff() >= kLeastDiscStddev_px) {
    window.size = kDiscWindow;
    window.by_outline = true;
  } else {
    stddev_px += kMargin_px / window.size;
  }
  window.covariance_px2 = axes * stddev_px.square().matrix().asDiagonal() * axes.transpose();
  return window;
}

std::optional<LightEllipse> measureSpot(const SearchedImage& image, const LightEllipse& thresholded,
                                        const SpotWindow& first_window, const Search& search,
                                        const DetectorConfig& config) {
  if (image.levels.cols < kPixelLanes) return std::nullopt;  // no room for a light
  SpotWindow window = first_window;
  const int row_step = rowStepFor(window);
  const PixelEllipse inside{window.centre_px, window.covariance_px2, kRingBegin * window.size};
  Background background =
      fitBackground(sumPlane(image.levels, inside, kRingEnd * window.size, row_step,
                             search.threshold_levels, search.background_levels),
                    search.background_levels);
  LevelPlane& plane = background.plane;
  const auto move = [&plane](const Vector2d& shift) { plane.at_centre += plane.slope.dot(shift); };
  auto step = stepFrom(image.levels, window, plane, config.view.centre_px());
  if (step && isLong(step->shift_px, window)) {
    move(step->shift_px);
    window.centre_px += step->shift_px;
    step = stepFrom(image.levels, window, plane, config.view.centre_px());
  }
  if (!step) return std::nullopt;
  const SpreadMoments spread = sumSpread(image.levels, image.sensed, window, row_step,
                                         polynomialOf(window), plane, config.sensor);
  if (!(spread.light > 0.0)) return std::nullopt;
  move(step->shift_px);

  LightEllipse light = thresholded;
  light.centre_px = window.centre_px + step->shift_px;
  light.mass_levels = step->sums.light;
  light.background_levels = plane.at_centre;
  takeSpread(spread, window, step->axes, &light);
  const Vector2d light_squares = row_step * diagonalAlong(step->axes, spread.noise_squares);
  light.noise_px2 = noiseOf(*step, window, light_squares, background, config);
  const double area_px =
      4.0 * kPi * std::sqrt(light.sensedVariances_px2(config.defocus_sigma_px).prod());
  light.saturated_fraction = std::min(1.0, row_step * spread.full_pixels / area_px);
  return light;
}

}  // namespace bearing_calibration::core
