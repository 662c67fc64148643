#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

inline constexpr double kPixelVariance = 1.0 / 12.0;  ///< of a square of side 1

/// Unit vectors at a place in the image, the columns: across the mirror's radius and along it (any
/// two at its centre; without a mirror the centre is any place).
/// Pairs of numbers along them stand in this order everywhere: (tangential, radial).
inline Eigen::Matrix2d mirrorAxes(const Eigen::Vector2d& place_px,
                                  const Eigen::Vector2d& mirror_centre_px) {
  const Eigen::Vector2d off_px = place_px - mirror_centre_px;
  const Eigen::Vector2d radial =
      off_px.isZero() ? Eigen::Vector2d::UnitX() : off_px.normalized().eval();
  return (Eigen::Matrix2d() << -radial.y(), radial.x(), radial.x(), radial.y()).finished();
}

/// The diagonal that a matrix in (u, v) has along the axes.
inline Eigen::Vector2d diagonalAlong(const Eigen::Matrix2d& axes, const Eigen::Matrix2d& matrix) {
  return (axes.transpose() * matrix * axes).diagonal();
}

/// Pixels whose Mahalanobis distance from the centre is at most the size.
struct PixelEllipse {
  Eigen::Vector2d centre_px;
  Eigen::Matrix2d covariance_px2;  ///< in (u, v)
  double size = 0.0;               ///< in standard deviations
};

/// The image of a light: an ellipse of light over its background, by intensity. Its axes are those
/// at its centre.
struct LightEllipse {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();    ///< (u, v)
  Eigen::Matrix2d moments_px2 = Eigen::Matrix2d::Zero();  ///< second central ones along the axes
  /// Variances of the centre (tangential, radial), by the noise of the pixels and what lies behind
  /// the light.
  Eigen::Vector2d noise_px2 = Eigen::Vector2d::Zero();
  double mass_levels = 0.0;        ///< sum of the light over the background
  double peak_levels = 0.0;        ///< largest level, background included
  double background_levels = 0.0;  ///< under the centre
  /// Mean of m^4 over the squared mean of m^2, m the Mahalanobis distance: 4/3 in an evenly filled
  /// ellipse, 2 in a Gaussian. NaN in spots that are too small for it, or blurred by software.
  double kurtosis = std::numeric_limits<double>::quiet_NaN();
  double fill = 0.0;                ///< of the thresholded spot, 1 for an ellipse
  double fill_tolerance = 0.0;      ///< of the fill, for the few pixels that the spot has
  double saturated_fraction = 0.0;  ///< of the spot's pixels as sensed
  int pixels = 0;                   ///< of the thresholded spot
  bool cut = false;                 ///< they reach the end of what was searched

  /// At least a pixel's: what is left of a spot without its background may seem to have less.
  Eigen::Vector2d variances_px2() const { return moments_px2.diagonal().cwiseMax(kPixelVariance); }
  /// As the sensor took the spot, before any software defocus.
  Eigen::Vector2d sensedVariances_px2(double defocus_sigma_px) const {
    return (variances_px2().array() - defocus_sigma_px * defocus_sigma_px).max(kPixelVariance);
  }
};

/// Why a bright spot is not taken for the light.
enum class Rejection : std::uint8_t {
  kNone,
  kTooFewPixels,
  kTooManyPixels,
  kFill,            ///< not an ellipse
  kMaskEdge,        ///< cut by the mask's edge or by a post
  kNoLight,         ///< nothing is left over the background
  kHorizon,         ///< higher than a light may be
  kTangentialSize,  ///< not the blur that the optics make
  kRadialSize,
  kAxis,          ///< not along the mirror's radius
  kKurtosis,      ///< brighter in the middle than what an open aperture makes of a light
  kUnlikely,      ///< by several small doubts
  kNoRay,         ///< beyond what the camera's lens shows
  kTooManySpots,  ///< not measured: the image has more spots than max_candidates
};
inline constexpr int kRejections = 14;

/// A few words for people.
const char* describe(Rejection rejection);

/// A bright spot of an image: the light, or what was mistaken for it and why it was not.
struct Detection {
  /// Where a gate before the measurement failed: centre, size, fill and pixels as thresholded.
  LightEllipse ellipse;
  Bearing bearing;  ///< only of an accepted spot
  Rejection rejection = Rejection::kNone;

  bool accepted() const { return rejection == Rejection::kNone; }
};

/// The gates that need only the thresholded pixels.
/// @param expected null where nothing is
Rejection rejectionOf(const LightEllipse& thresholded, const GateConfig& gates,
                      const ExpectedSpot* expected);

/// How a spot was found: the more was tried, the less it says.
struct Search {
  bool opened = false;             ///< beside bright areas, which were taken away
  double part_searched = 1.0;      ///< of the mask: where less is searched, less is clutter
  double background_levels = 0.0;  ///< median
  int thresholds = 0;              ///< that were tried
  int threshold_levels = 0;        ///< the last of them
  int spots = 0;                   ///< over that
};

struct LightProbability {
  /// In 0 to 1, that the spot is a light rather than clutter. It says how much like a light the
  /// spot is, not which of several lights it is.
  double value = 0.0;
  Rejection doubt = Rejection::kUnlikely;  ///< the largest one; kUnlikely where none is large
};

/// @param expected null where nothing is
LightProbability probabilityOf(const LightEllipse& ellipse, const ExpectedSpot* expected,
                               const Search& search);

}  // namespace bearing_calibration::core
