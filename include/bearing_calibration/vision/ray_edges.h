#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace bearing_calibration::core {

/// Rays from a point of an image, evenly all around, and the part of each that is looked at.
struct RayFan {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  int rays = 0;
  double begin_px = 0.0;
  double end_px = 0.0;
};

/// Where the brightness changes fastest along a ray.
struct RayEdge {
  int ray = 0;
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();  ///< (u, v), a fraction of a pixel
  double slope = 0.0;                                  ///< size of the change [levels/px]
};

/// Finds edges along rays, between pixels, in an image smoothed for it once.
class RayEdgeFinder {
 public:
  /// @param image CV_8UC1 or CV_16UC1. @param saturation_level an edge beside a pixel of this level
  ///   or more is left out: its place depends on what was clipped.
  RayEdgeFinder(const cv::Mat& image, double saturation_level);

  /// The at most `most_per_ray` steepest edges of each ray, by ray. Those that stand no higher than
  /// the image's noise and texture are left out.
  std::vector<RayEdge> find(const RayFan& fan, std::size_t most_per_ray) const;

 private:
  std::vector<double> profileOf(const RayFan& fan, const Eigen::Vector2d& direction) const;
  bool nearFullPixel(const Eigen::Vector2d& place_px) const;

  cv::Mat smooth_;     ///< CV_32FC1
  cv::Mat near_full_;  ///< CV_8UC1, not 0 near a full pixel
  double least_slope_ = 0.0;
};

}  // namespace bearing_calibration::core
