#pragma once

#include <Eigen/Core>
#include <functional>
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

/// What a camera makes of a light, by the image radius: all that the detector knows of lens and
/// mirror. Any other camera that looks alike in all directions about its axis can have its own.
struct LightOptics {
  std::function<SpotSize(double image_radius_px)> sizeAt;
  /// For a variance of the image radius.
  std::function<Elevation(double image_radius_px, double variance_px2)> elevationAt;
  double largest_radius_px = 0.0;  ///< outside no light is seen, whatever is not known
  double rim_radius_px = 0.0;      ///< here ends what is seen of the surroundings
};

/// The conic mirror's: the blur of the open aperture, the light's own size, the pixels' size and
/// the software's defocus. A light lies inside the horizon of the highest one that stands nearest.
LightOptics conicMirrorOptics(const DetectorConfig& config);

/// What a light's image is expected to look like at a place in the image: a camera's optics,
/// tabulated over the mask.
class ExpectedSpot {
 public:
  ExpectedSpot(const LightOptics& optics, const DetectorConfig& config);

  const LightOptics& optics() const { return optics_; }
  const SpotSize& at(const Eigen::Vector2d& place_px) const;
  bool mayStandAt(const Eigen::Vector2d& place_px) const;  ///< or too high for a light
  /// Area [px] of the spots that can be seen anywhere in the mask.
  const Range& area_px() const { return area_px_; }
  /// Of the smallest light's spots, along either axis.
  double largestPointStddev_px() const { return largest_point_stddev_px_; }

 private:
  LightOptics optics_;
  Eigen::Vector2d centre_px_;
  std::vector<SpotSize> sizes_;  ///< by image radius in whole pixels
  Range area_px_;
  double largest_point_stddev_px_ = 0.0;
};

}  // namespace bearing_calibration::core
