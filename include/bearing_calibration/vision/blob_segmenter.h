#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/pixel_kernels.h"
#include "bearing_calibration/vision/pixel_strip.h"

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

/// Finds the connected pixels above a threshold in one pass over the mask's strips: runs, joined
/// by union-find, each adding closed sums to its blob. Buffers are kept from image to image.
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
  static constexpr int kNoLabel = -1;

  struct RunSums;

  /// Runs [first, last), counted through all rows.
  struct RunRange {
    std::size_t first = 0;
    std::size_t last = 0;
  };

  std::size_t addLoneRuns(std::size_t i, std::size_t rows, int last_row, RunSums* total);
  bool join(const std::vector<PixelStrip>& strips, std::size_t rows);
  int labelOf(int begin, int end, RunRange* above);
  int root(int label);
  void collect();

  std::vector<BrightRow> rows_;
  std::vector<int> edges_;    ///< where their runs begin and end, in turn
  std::vector<int> labels_;   ///< of the runs
  std::vector<int> parents_;  ///< of the labels
  std::vector<Blob> blobs_;   ///< by label, then by root
  bool complete_ = true;
};

/// Second central moments of the blob's pixels as small squares (a lone pixel has 1/12) [px^2].
struct BlobShape {
  double centre_u_px;
  double centre_v_px;
  double variance_uu_px2;
  double variance_uv_px2;
  double variance_vv_px2;
  double fill;  ///< pixels over the area 4 pi sqrt(det) of the ellipse with these moments
};
BlobShape shapeOf(const Blob& blob);

}  // namespace bearing_calibration::core
