#pragma once

#include <Eigen/Core>
#include <limits>

namespace bearing_calibration::core {

inline constexpr double kPixelVariance = 1.0 / 12.0;  ///< of a square of side 1

/// Unit vectors at a place in the image, along the mirror's radius and across it.
struct MirrorAxes {
  MirrorAxes(const Eigen::Vector2d& place_px, const Eigen::Vector2d& mirror_centre_px)
      : radial((place_px - mirror_centre_px).normalized()), tangential(-radial.y(), radial.x()) {}

  /// In (u, v), of what has these variances along the axes.
  Eigen::Matrix2d covariance(double radial_variance, double tangential_variance) const {
    return radial_variance * radial * radial.transpose() +
           tangential_variance * tangential * tangential.transpose();
  }

  Eigen::Vector2d radial;
  Eigen::Vector2d tangential;
};

/// The image of a light: an ellipse of light over its background, by intensity. "Along" and
/// "across" are the mirror's radius and its tangent at the centre.
struct LightEllipse {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< (u, v)
  double tangential_variance_px2 = 0.0;                 ///< second central moments
  double radial_variance_px2 = 0.0;
  double mixed_variance_px2 = 0.0;
  double mass_levels = 0.0;        ///< sum of the light over the background
  double peak_levels = 0.0;        ///< largest level, background included
  double background_levels = 0.0;  ///< under the centre
  /// Fourth moment over squared second one (spot_meter.h); NaN where it says nothing: in spots that
  /// are too small, or blurred by software.
  double kurtosis = std::numeric_limits<double>::quiet_NaN();
  double fill = 0.0;                ///< of the thresholded spot, 1 for an ellipse
  double fill_tolerance = 0.0;      ///< of the fill, for the few pixels that the spot has
  double saturated_fraction = 0.0;  ///< of the spot's pixels as sensed
  int pixels = 0;                   ///< of the thresholded spot
};

/// Variances of the centre by what the image itself shows.
struct CentreVariance {
  double tangential_px2 = 0.0;
  double radial_px2 = 0.0;

  CentreVariance& operator+=(const CentreVariance& more) {
    tangential_px2 += more.tangential_px2;
    radial_px2 += more.radial_px2;
    return *this;
  }
};

}  // namespace bearing_calibration::core
