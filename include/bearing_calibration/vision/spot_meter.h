#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/vision/light_ellipse.h"
#include "bearing_calibration/vision/spot_sums.h"

namespace bearing_calibration::core {

/// How the pixels of a window count for the spot's centre c, the root of sum((I - b) w (x - c)).
enum class CentreWeight : std::uint8_t {
  kEven,  ///< w = 1: the centroid, best for a Gaussian spot
  /// w = m^2 (1 - (m / size)^4), m the Mahalanobis distance from c: the outline of an evenly filled
  /// disc says where it stands, its inside adds noise only; nothing at the window's edge.
  kOutline,
};

/// The pixels that are looked at, in units of the spot's covariance.
struct SpotWindow : PixelEllipse {
  CentreWeight weight = CentreWeight::kEven;
};

/// The background under a spot.
struct Background {
  LevelPlane plane;
  double residual_variance = 0.0;  ///< of the ring's pixels about the plane [levels^2]
  double sum_of_squares = 0.0;     ///< of the ring's pixels' distances along one axis [px^2]
};

/// Sums over a window along one axis x through its centre. I the levels, b the background, w the
/// weights, phi = w x: noise e of the pixels moves the centre by sum(e phi) / gain.
struct AxisSums {
  double gain = 0.0;           ///< d sum((I - b) phi) / d centre
  double variance_px2 = 0.0;   ///< second moment of the light: sum((I - b) x^2) / sum(I - b)
  double light_noise = 0.0;    ///< sum(N phi^2), N the noise that grows with the light [levels^2]
  double pixel_squares = 0.0;  ///< sum(phi^2)
  double slope_lever = 0.0;    ///< sum(x phi): how a slope of the background moves the centre
};

/// What the pixels of a window say.
struct SpotMeasurement {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double mass_levels = 0.0;  ///< sum(I - b)
  double peak_levels = 0.0;
  AxisSums tangential;
  AxisSums radial;
  double mixed_variance_px2 = 0.0;
  /// Mean of m^4 over the squared mean of m^2, m the Mahalanobis distance: 4/3 in an evenly filled
  /// ellipse, 2 in a Gaussian.
  double kurtosis = 0.0;
  int full_pixels = 0;
  Background background;
};

/// What separates the pixels of an image.
struct SpotLevels {
  double threshold = 0.0;   ///< ring pixels above it are not background
  double background = 0.0;  ///< used where the ring has too few pixels
  LevelNoise noise;
};

/// The centre of the light over a background plane in an elliptical window: a Newton step from the
/// window's centre, two if the first is long. The axes are radial and tangential about
/// `mirror_centre_px`.
/// @param image CV_8UC1 or CV_16UC1
/// @param sharp the same before any software defocus, in which full pixels are counted
/// @return nothing when the window holds no light over its background, or the image has fewer than
///   kPixelLanes columns.
std::optional<SpotMeasurement> measureSpot(const cv::Mat& image, const cv::Mat& sharp,
                                           const SpotWindow& window, const SpotLevels& levels,
                                           const Eigen::Vector2d& mirror_centre_px);

}  // namespace bearing_calibration::core
