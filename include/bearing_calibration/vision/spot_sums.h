#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace bearing_calibration::core {

/// Pixels whose Mahalanobis distance from the centre is at most the size.
struct PixelEllipse {
  Eigen::Vector2d centre_px;
  Eigen::Matrix2d covariance_px2;  ///< in (u, v)
  double size = 0.0;               ///< in standard deviations
};

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

/// How a pixel's noise grows with what it sees: variance = per_level (I - black) + per_square
/// (I - b)^2 [levels^2]; the first part not where the pixel is full.
struct LevelNoise {
  double black = 0.0;
  double saturation = 0.0;
  double per_level = 0.0;
  double per_square = 0.0;
};

/// Sums over an ellipse's pixels d from its centre: I the level, L = I - b over the background, w
/// the weight and w' its derivative over m^2. What a light's centre needs:
struct CentreMoments {
  double light = 0.0;                                        ///< sum(L)
  double weighted = 0.0;                                     ///< sum(L w)
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();          ///< sum(L w d)
  Eigen::Matrix2d sloped_squares = Eigen::Matrix2d::Zero();  ///< sum(L w' d d^T)
};

/// What its size, shape and variance need besides: N the noise's variance.
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
                        const LevelNoise& noise);

}  // namespace bearing_calibration::core
