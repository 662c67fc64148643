#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/vision/light_ellipse.h"

namespace bearing_calibration {

/// An elliptical window: pixels whose Mahalanobis distance from the centre is at most its size.
struct SpotWindow {
  Eigen::Vector2d centre_px;
  Eigen::Matrix2d covariance_px2;  ///< of the spot in (u, v)
  double size = 0.0;               ///< in standard deviations
};

/// The background under a spot: levels = at_centre + slope . (pixel - centre).
struct BackgroundPlane {
  double at_centre = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double residual_variance = 0.0;  ///< of the ring's pixels about the plane [levels^2]
  double sum_of_squares = 0.0;     ///< of the ring's pixels' distances along one axis [px^2]
};

/// Sums over a window along one axis x through the centre; I the levels, b the background,
/// S = sum(I - b).
struct AxisSums {
  double variance_px2 = 0.0;       ///< sum((I - b) x^2) / S
  double light_squares = 0.0;      ///< sum(I x^2) over pixels that are not full
  double pixel_squares = 0.0;      ///< sum(x^2)
  double intensity_squares = 0.0;  ///< sum((I - b)^2 x^2)
};

/// What the pixels of a window say.
struct SpotMeasurement {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double mass_levels = 0.0;  ///< S
  double peak_levels = 0.0;
  AxisSums tangential;
  AxisSums radial;
  double mixed_variance_px2 = 0.0;
  int full_pixels = 0;
  BackgroundPlane background;
};

/// Levels of the image that separate its pixels.
struct SpotLevels {
  double threshold = 0.0;   ///< ring pixels above it are not background
  double saturation = 0.0;  ///< full from here on
  double black = 0.0;       ///< of a pixel without light
  double background = 0.0;  ///< used where the ring has too few pixels
};

/// Intensity centroid over a background plane in an elliptical window, twice: the second window
/// stands on the first centroid. The axes are radial and tangential about `mirror_centre_px`.
/// @param image CV_8UC1 or CV_16UC1
/// @param sharp the same before any software defocus, in which full pixels are counted
/// @return nothing when the window holds no light over its background.
std::optional<SpotMeasurement> measureSpot(const cv::Mat& image, const cv::Mat& sharp,
                                           const SpotWindow& window, const SpotLevels& levels,
                                           const Eigen::Vector2d& mirror_centre_px, int handedness);

}  // namespace bearing_calibration
