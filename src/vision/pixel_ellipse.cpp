#include "bearing_calibration/vision/pixel_ellipse.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace bearing_calibration::core {

EllipseShape::EllipseShape(const Eigen::Matrix2d& covariance_px2)
    : information(covariance_px2.inverse()),
      stddev_u_px(std::sqrt(covariance_px2(0, 0))),
      stddev_v_px(std::sqrt(covariance_px2(1, 1))) {}

PixelBox PixelEllipse::box(const cv::Size& image) const {
  const double half_width = reach * shape.stddev_u_px;
  const double half_height = reach * shape.stddev_v_px;
  const auto first_after = [](double place, int last) {
    return static_cast<int>(std::clamp(place + 1.0, 0.0, static_cast<double>(last)));
  };
  return {first_after(centre_px.y() - half_height, image.height),
          first_after(centre_px.y() + half_height, image.height),
          first_after(centre_px.x() - half_width, image.width),
          first_after(centre_px.x() + half_width, image.width)};
}

}  // namespace bearing_calibration::core
