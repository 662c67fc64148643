#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/annulus_mask.h"

namespace bearing_calibration::core {

/// Connected bright pixels (8 neighbours) by their integer moments.
struct Blob {
  std::int64_t pixels = 0;
  std::int64_t sum_u = 0;
  std::int64_t sum_v = 0;
  std::int64_t sum_uu = 0;
  std::int64_t sum_uv = 0;
  std::int64_t sum_vv = 0;
  bool cut = false;  ///< reaches an end of a strip of the mask, its first row or its last
};

/// Finds the connected pixels above a threshold: runs of the mask's strips, joined by union-find,
/// each adding closed sums to its blob. Buffers are kept from image to image.
class BlobSegmenter {
 public:
  BlobSegmenter();

  /// @param image CV_8UC1 or CV_16UC1. @param strips in reading order.
  /// @return the blobs, valid until the next call; complete() tells whether they are all.
  const std::vector<Blob>& segment(const cv::Mat& image, const std::vector<PixelStrip>& strips,
                                   int threshold);

  /// False when the last image had more bright runs than a scene with a light can have.
  bool complete() const { return complete_; }

 private:
  /// Bright pixels [begin, end) of a row.
  struct Run {
    int row;
    int begin;
    int end;
    bool cut;
    std::size_t parent;  ///< a run that this one is joined with; itself, of one that stands for all
    std::size_t blob;    ///< of one that stands for all
  };

  template <typename Level>
  bool findRuns(const cv::Mat& image, const std::vector<PixelStrip>& strips, int threshold);
  std::size_t rootOf(std::size_t run);
  bool join();
  void addUp();

  std::vector<int> edges_;  ///< of a row's runs
  std::vector<Run> runs_;
  std::vector<Blob> blobs_;
  bool complete_ = true;
};

/// Second central moments of the blob's pixels as small squares (a lone pixel has 1/12) [px^2].
struct BlobShape {
  Eigen::Vector2d centre_px;  ///< (u, v)
  Eigen::Matrix2d covariance_px2;
  double fill;  ///< pixels over the area 4 pi sqrt(det) of the ellipse with these moments
};
BlobShape shapeOf(const Blob& blob);

}  // namespace bearing_calibration::core
