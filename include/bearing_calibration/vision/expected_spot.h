#pragma once

#include <Eigen/Core>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

struct Range {
  double low = 0.0;
  double high = 0.0;
};

/// How a light's image looks, for every distance and size that the light may have. Pairs are
/// (tangential, radial): along the azimuth and along the image's radius.
struct SpotSize {
  Eigen::Vector2d least_stddev_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d most_stddev_px = Eigen::Vector2d::Zero();
  /// Of the smallest light, logarithms of the standard deviations: the middle, and the covariance
  /// by what is not known of optics and distance.
  Eigen::Vector2d log_point = Eigen::Vector2d::Zero();
  Eigen::Matrix2d log_covariance = Eigen::Matrix2d::Identity();
  double max_kurtosis = 0.0;  ///< of the smallest light: fourth moment over squared second one

  /// Of the smallest light, larger by this many standard deviations than it is expected.
  Eigen::Vector2d pointStddev_px(double sigmas) const;
  /// The factor by which the optics' uncertainty widens the range, either way.
  Eigen::Vector2d widening() const;
};

/// Standard deviation of a ring of light along any axis, over its radius: anything filled has less.
inline constexpr double kRingStddev = 0.70710678118654752;

/// Variances [px^2] of a light's image (tangential, radial).
struct SpotVariances {
  Eigen::Array2d open_px2;  ///< of the open aperture's evenly filled ellipse
  Eigen::Array2d own_px2;   ///< of the light itself
};

/// @param sideways_stddev_m  of the light's surface, as are the upward ones
SpotVariances spotVariances(const ConicMirror& mirror, double image_radius_px, double distance_m,
                            double sideways_stddev_m, double upward_stddev_m);

/// What the conic mirror makes of a light: the blur of the open aperture, the light's own size, the
/// pixels' size and the software's defocus.
SpotSize spotSizeAt(const DetectorConfig& config, double image_radius_px);

/// Outside of this image radius [px] the mirror shows no light, whatever is not known: the horizon
/// of the highest one that stands nearest, with the optics' uncertainty; the rim's at most.
double largestLightRadiusPx(const DetectorConfig& config);

/// What a light's image is expected to look like at a place in the image, tabulated over the mask.
class ExpectedSpot {
 public:
  /// Of a conic mirror's lights.
  explicit ExpectedSpot(const DetectorConfig& config);
  /// @param sizes  by the image radius in whole pixels, from 0 to the mask's end or that of what
  ///   is seen of the surroundings
  /// @param largest_radius_px  outside no light is seen
  ExpectedSpot(std::vector<SpotSize> sizes, double largest_radius_px, const DetectorConfig& config);

  const SpotSize& at(const Eigen::Vector2d& place_px) const;
  bool mayStandAt(const Eigen::Vector2d& place_px) const;  ///< or too high for a light
  /// Area [px] of the spots that can be seen anywhere in the mask.
  const Range& area_px() const { return area_px_; }
  /// Of the smallest light's spots, along either axis.
  double largestPointStddev_px() const { return largest_point_stddev_px_; }

 private:
  std::vector<SpotSize> sizes_;  ///< by image radius in whole pixels
  double largest_radius_px_;
  Eigen::Vector2d centre_px_;
  Range area_px_;
  double largest_point_stddev_px_ = 0.0;
};

}  // namespace bearing_calibration::core
