#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "bearing_calibration/vision/pixel_box.h"

namespace bearing_calibration::core {

/// What an ellipse's loops want of its covariance, worked out once.
struct EllipseShape {
  explicit EllipseShape(const Eigen::Matrix2d& covariance_px2);

  Eigen::Matrix2d information;  ///< inverse of the covariance [1/px^2]
  double stddev_u_px;
  double stddev_v_px;
};

/// Pixels whose Mahalanobis distance from the centre is at most `reach`.
struct PixelEllipse {
  Eigen::Vector2d centre_px;
  EllipseShape shape;
  double reach;  ///< in standard deviations

  PixelEllipse reaching(double new_reach) const { return {centre_px, shape, new_reach}; }
  /// The smallest box with all its pixels that an image of this size has.
  PixelBox box(const cv::Size& image) const;
};

}  // namespace bearing_calibration::core
