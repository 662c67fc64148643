#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/vision/detector_config.h"
#include "bearing_calibration/vision/expected_spot.h"

namespace bearing_calibration::core {

struct Circle {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< (u, v)
  double radius_px = 0.0;
};

/// The circle through three points; none when they lie in a line.
std::optional<Circle> circleThrough(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                    const Eigen::Vector2d& c);

struct CircleFit {
  Circle circle;
  /// Of (centre u, centre v, radius), from the points' own scatter: neighbours within ten degrees
  /// may err together.
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();
  double scatter_px = 0.0;  ///< robust standard deviation of the points about the circle
  std::vector<Eigen::Vector2d> points_px;  ///< that belong to it: no outliers

  double stddev(int parameter) const;  ///< of 0: centre u, 1: centre v, 2: radius [px]
};

/// The circle of least (Tukey) loss of the points' distances from it, beginning at `start`; as long
/// as fewer than half of the points are strangers, these do not count.
/// @return none when the points do not determine a circle.
std::optional<CircleFit> fitCircle(const std::vector<Eigen::Vector2d>& points_px,
                                   const Circle& start);

/// Where the mirror's rim may lie in an image.
struct RimSearch {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double max_centre_error_px = 0.0;  ///< the rim's centre is not farther from that
  Range radius_px;
  double saturation_level = 0.0;  ///< an edge beside a full pixel is left out: it is clipped
};

/// Around what is configured.
RimSearch rimSearchAround(const DetectorConfig& config);
/// In an image of which nothing is known.
RimSearch rimSearchIn(const cv::Mat& image);

/// The mirror's rim as it stands in an image: a circle, in an aligned rig about the mirror's axis.
/// Its points are the places of its edge.
struct MirrorRim : CircleFit {
  double visible_part = 0.0;  ///< of all directions: those in which the rim's edge was found
};

/// Finds the circle with the longest visible edge: edges on rays, circles through three of them,
/// then a robust fit to the edges on rays from its own centre. Parts of the rim may be hidden or
/// lie outside of the image. The same image gives the same answer.
/// @param image CV_8UC1 or CV_16UC1
/// @return none when no circle is seen in at least a third of the directions.
/// @throws std::invalid_argument for an image of another type, or a search that is empty.
std::optional<MirrorRim> findMirrorRim(const cv::Mat& image, const RimSearch& search);

/// What the mirror's rim, as seen, says of the configuration.
struct MirrorCheck {
  bool consistent = true;
  std::vector<std::string> sentences;  ///< what was compared, and what to change
};

/// Compares the rim's centre with the configured one (by both uncertainties), its radius with the
/// one that lens and mirror make, and the mask with the rim.
MirrorCheck checkMirror(const MirrorRim& rim, const DetectorConfig& config);

}  // namespace bearing_calibration::core
