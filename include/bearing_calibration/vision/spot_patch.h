#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/annulus_mask.h"
#include "bearing_calibration/vision/pixel_kernels.h"

namespace bearing_calibration {

/// What an ellipse's loops want of its covariance, worked out once.
struct EllipseShape {
  explicit EllipseShape(const Eigen::Matrix2d& covariance_px2);

  Eigen::Matrix2d information;  ///< inverse of the covariance [1/px^2]
  double stddev_u_px;
  double stddev_v_px;
  double skew;           ///< by which a chord's middle moves from row to row
  double chord_var_px2;  ///< squared half length of the chord through the centre, at a reach of 1
};

/// Pixels whose Mahalanobis distance from the centre is at most `reach`.
struct PixelEllipse {
  Eigen::Vector2d centre_px;
  EllipseShape shape;
  double reach;  ///< in standard deviations

  PixelEllipse reaching(double new_reach) const { return {centre_px, shape, new_reach}; }
  /// All its pixels that an image of this size has.
  PixelBox box(const cv::Size& image) const;
};

/// The levels of a box of an image as numbers, for loops that know nothing of images. Keeps its
/// buffer.
class SpotPatch {
 public:
  /// @param image CV_8UC1 or CV_16UC1, which has all of `box`.
  void copy(const cv::Mat& image, const PixelBox& box);

  const PixelBox& box() const { return box_; }
  bool contains(const PixelBox& box) const {
    return box.first_row >= box_.first_row && box.last_row <= box_.last_row &&
           box.first_column >= box_.first_column && box.last_column <= box_.last_column;
  }
  LevelRows levels() const { return {levels_.data(), columns()}; }
  int columns() const { return box_.last_column - box_.first_column; }
  /// An image's place in coordinates of the patch.
  Eigen::Vector2d fromImage(const Eigen::Vector2d& place_px) const {
    return place_px - Eigen::Vector2d(box_.first_column, box_.first_row);
  }

 private:
  PixelBox box_;
  std::vector<float> levels_;
};

/// The pixels of ellipses in a patch, row by row. Keeps its buffers.
class PatchSpans {
 public:
  const RowSpans& ofEllipse(const SpotPatch& patch, const PixelEllipse& ellipse);

  /// Those between two ellipses about one centre.
  const RowSpans& ofRing(const SpotPatch& patch, const PixelEllipse& inner,
                         const PixelEllipse& outer);

  const RowSpans& current() const { return spans_; }  ///< what was asked for last

 private:
  void takeRows(const SpotPatch& patch, const PixelEllipse& ellipse, int pieces);

  RowSpans spans_;
  std::vector<int> begin_;
  std::vector<int> end_;
};

}  // namespace bearing_calibration
