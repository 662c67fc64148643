#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>

#include "bearing_calibration/vision/detection.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

/// The weight of a pixel at the Mahalanobis distance m: constant + m^2 (square + sixth m^4).
struct WeightPolynomial {
  float at(float m2) const { return constant + m2 * (square + sixth * (m2 * m2)); }
  float slope(float m2) const { return square + 3.0F * sixth * (m2 * m2); }  ///< over m^2

  float constant = 1.0F;
  float square = 0.0F;
  float sixth = 0.0F;
};

/// The levels of a background: at_centre + slope . (pixel - centre).
struct LevelPlane {
  float at(float u, float v) const {
    return static_cast<float>(at_centre) + static_cast<float>(slope.x()) * u +
           static_cast<float>(slope.y()) * v;
  }

  double at_centre = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
};

/// Sums over pixels d from a centre, of levels less `reference`: of which a plane is the least
/// squares' answer.
struct PlaneSums {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  ///< sum(x x^T), x = (1, d_u, d_v)
  Eigen::Vector3d right = Eigen::Vector3d::Zero();   ///< sum(x (level - reference))
  double squares = 0.0;                              ///< sum((level - reference)^2)
};

/// Sums over an ellipse's pixels d from its centre: I the level, L = I - b over the background, w
/// the weight and w' its derivative over m^2. What a light's centre needs:
struct CentreMoments {
  double light = 0.0;                                        ///< sum(L)
  double weighted = 0.0;                                     ///< sum(L w)
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();          ///< sum(L w d)
  Eigen::Matrix2d sloped_squares = Eigen::Matrix2d::Zero();  ///< sum(L w' d d^T)
};

/// What its size, shape and variance need besides: N the part of a pixel's noise that grows with
/// what it sees, (I - black) / electrons per level + (response spread (I - b))^2 [levels^2], the
/// first part not where the pixel is full.
struct SpreadMoments {
  double light = 0.0;                                       ///< sum(L)
  Eigen::Matrix2d light_squares = Eigen::Matrix2d::Zero();  ///< sum(L d d^T)
  Eigen::Matrix2d noise_squares = Eigen::Matrix2d::Zero();  ///< sum(N w^2 d d^T)
  double fourth_powers = 0.0;                               ///< sum(L m^4)
  double peak = 0.0;                                        ///< largest I
  int full_pixels = 0;
};

/// The loops over an image's columns take so many pixels side by side.
inline constexpr int kPixelLanes = 8;

// The sums take every row_step-th row of a CV_8UC1 or CV_16UC1 image of kPixelLanes columns at
// least. They add up the same numbers in the same order, whatever instructions they are made of.

/// Over the pixels from the inner ellipse to the one of the outer size whose level is at most
/// `threshold`.
PlaneSums sumPlane(const cv::Mat& image, const PixelEllipse& inner, double outer_size, int row_step,
                   double threshold, double reference);

/// Over an ellipse's pixels.
CentreMoments sumCentre(const cv::Mat& image, const PixelEllipse& window, int row_step,
                        WeightPolynomial weight, const LevelPlane& background);

/// @param sensed the image before any software defocus
SpreadMoments sumSpread(const cv::Mat& image, const cv::Mat& sensed, const PixelEllipse& window,
                        int row_step, WeightPolynomial weight, const LevelPlane& background,
                        const ImageSensor& sensor);

/// The pixels that are looked at, and how they count for the centre c, the root of
/// sum((I - b) w (x - c)).
struct SpotWindow : PixelEllipse {
  /// w = m^2 (1 - (m / size)^4), m the Mahalanobis distance from c: the outline of an evenly filled
  /// disc says where it stands, its inside adds noise only; nothing at the window's edge. Otherwise
  /// w = 1: the centroid, best for a Gaussian spot.
  bool by_outline = false;
};

/// Around a spot's thresholded pixels. Where a spot is expected, the window lies along the mirror's
/// radius and has a size that the optics can make: clutter beside the light stays outside. Where
/// nothing is, it follows the pixels.
SpotWindow windowFor(const LightEllipse& thresholded, const ExpectedSpot* expected,
                     const DetectorConfig& config);

/// An image as it is searched, CV_8UC1 or CV_16UC1, and as the sensor took it, before any software
/// defocus: there full pixels are counted.
struct SearchedImage {
  const cv::Mat& levels;
  const cv::Mat& sensed;
};

/// The light over a background plane in an elliptical window, its centre by a Newton step from the
/// window's centre, two if the first is long.
/// @param thresholded what the spot's pixels over the threshold say, which stays
/// @return nothing when the window holds no light over its background, or the image has fewer than
///   kPixelLanes columns.
std::optional<LightEllipse> measureSpot(const SearchedImage& image, const LightEllipse& thresholded,
                                        const SpotWindow& window, const Search& search,
                                        const DetectorConfig& config);

}  // namespace bearing_calibration::core
