#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "bearing_calibration/vision/pixel_kernels.h"

namespace bearing_calibration::core {

template <typename Level>
ImageRows<Level> rowsOf(const cv::Mat& image) {
  return {image.ptr<Level>(0), static_cast<std::ptrdiff_t>(image.step1()), image.cols};
}

/// Calls `visit` with the rows of a CV_8UC1 or CV_16UC1 image and the loops over such levels.
template <typename Visit>
auto visitLevels(const cv::Mat& image, Visit visit) {
  const PixelKernels& kernels = pixelKernels();
  return image.depth() == CV_8U ? visit(rowsOf<std::uint8_t>(image), kernels.bytes)
                                : visit(rowsOf<std::uint16_t>(image), kernels.words);
}

}  // namespace bearing_calibration::core
