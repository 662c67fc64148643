#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "bearing_calibration/vision/spot_sums.h"

namespace bearing_calibration {

/// A row of an ellipse: columns [begin, end), of which [inner_begin, inner_end) belong to a smaller
/// one of the same shape inside it.
struct PixelChord {
  int begin = 0;
  int inner_begin = 0;
  int inner_end = 0;
  int end = 0;
};

/// The pixels around a spot, copied one after the other so that sums over them are plain loops.
class SpotPixels {
 public:
  /// Takes the pixels of an ellipse; those nearer to its centre than `inner_reach` standard
  /// deviations make the window, the others the ring. Buffers are kept.
  /// @param image CV_8UC1 or CV_16UC1.
  /// @param sharp the same before any software defocus.
  void gather(const cv::Mat& image, const cv::Mat& sharp, const PixelEllipse& ellipse,
              double inner_reach);

  const PixelColumn& window() const { return window_; }  ///< places from the ellipse's centre
  const PixelColumn& ring() const { return ring_; }
  /// The window's levels in the sharp image.
  const std::vector<float>& sensed() const {
    return sharp_is_image_ ? window_.levels : sharp_window_.levels;
  }

 private:
  std::vector<PixelChord> chords_;
  PixelColumn window_;
  PixelColumn sharp_window_;  ///< used where the sharp image is another one
  PixelColumn ring_;
  bool sharp_is_image_ = true;
};

}  // namespace bearing_calibration
