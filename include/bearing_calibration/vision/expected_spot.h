#pragma once

#include <Eigen/Core>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"

namespace bearing_calibration::core {

struct Range {
  double low = 0.0;
  double high = 0.0;
};

/// Standard deviations of a light's image along the azimuth and along the mirror's radius, for
/// every distance and size that the light may have.
struct SpotSize {
  Range tangential_stddev_px;
  Range radial_stddev_px;
  /// Of the smallest light, logarithms of the standard deviations (tangential, radial): the middle,
  /// and the covariance by what is not known of optics and distance.
  Eigen::Vector2d log_point = Eigen::Vector2d::Zero();
  Eigen::Matrix2d log_covariance = Eigen::Matrix2d::Identity();
  double max_kurtosis = 0.0;  ///< of the smallest light: fourth moment over squared second one

  /// Of the smallest light, larger by this many standard deviations than it is expected.
  Eigen::Vector2d pointStddev_px(double sigmas) const {
    return (log_point + sigmas * log_covariance.diagonal().cwiseSqrt()).array().exp();
  }

  /// The ranges, wider by what the optics' uncertainty makes of them.
  Range possibleTangential_px() const {
    return widened(tangential_stddev_px, log_covariance(0, 0));
  }
  Range possibleRadial_px() const { return widened(radial_stddev_px, log_covariance(1, 1)); }

 private:
  static Range widened(const Range& range, double log_variance);
};

/// At one image radius; at the rim's beyond it.
SpotSize expectedSpotSize(const DetectorConfig& config, double image_radius_px);

/// Outside of this image radius no light is seen: the horizon of the highest light that stands
/// nearest, with the optics' uncertainty; the rim's at most.
double largestRadiusPx(const DetectorConfig& config);

/// The image that the optics make of the light, tabulated over the image radius: the blur of the
/// open aperture, the light's own size, the pixels' size and the software's defocus. Nothing is
/// expected (zeros) when the mirror's gates are off.
class ExpectedSpot {
 public:
  explicit ExpectedSpot(const DetectorConfig& config);

  const SpotSize& at(double image_radius_px) const;
  /// Area [px] of the spots that can be seen anywhere in the mask.
  const Range& area_px() const { return area_px_; }
  /// Of the smallest light's spots, along either axis.
  double largest_point_stddev_px() const { return largest_point_stddev_px_; }

 private:
  std::vector<SpotSize> sizes_;  ///< by image radius in whole pixels
  Range area_px_;
  double largest_point_stddev_px_ = 0.0;
};

}  // namespace bearing_calibration::core
