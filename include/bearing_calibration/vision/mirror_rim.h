#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "bearing_calibration/vision/circle_fit.h"
#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

/// Where the mirror's rim may lie in an image.
struct RimSearch {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double max_centre_error_px = 0.0;  ///< the rim's centre is not farther from that
  Range radius_px;
  double saturation_level = 0.0;  ///< an edge beside a full pixel is left out
};

/// Around what is configured.
RimSearch rimSearchAround(const DetectorConfig& config);
/// In an image of which nothing is known.
RimSearch rimSearchIn(const cv::Mat& image);

/// The mirror's rim as it stands in an image: a circle, in an aligned rig about the mirror's axis.
struct MirrorRim {
  Circle circle;
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();  ///< of (centre u, centre v, radius)
  double visible_part = 0.0;  ///< of all directions: those in which the rim's edge was found
  double scatter_px = 0.0;    ///< robust standard deviation of the edge about the circle
  std::vector<Eigen::Vector2d> edge_px;  ///< the places that speak for it

  double stddev(int parameter) const;  ///< of 0: centre u, 1: centre v, 2: radius [px]
};

/// Finds the circle with the longest visible edge: edges on rays, circles through three of them,
/// then a robust fit to the edges on rays from its own centre. Parts of the rim may be hidden or
/// lie outside of the image. The same image gives the same answer.
/// @param image CV_8UC1 or CV_16UC1
/// @return none when no circle is seen in at least a third of the directions.
/// @throws std::invalid_argument for an image of another type, or a search that is empty.
std::optional<MirrorRim> findMirrorRim(const cv::Mat& image, const RimSearch& search);

}  // namespace bearing_calibration::core
