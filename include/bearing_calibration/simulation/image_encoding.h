#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {

/// An 8-bit image of the sensor's own values, row by row without gaps.
struct MonoImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> values;
};

/// What a camera's driver makes of the sensor's values.
struct ImageEncoding {
  enum class Layout : std::uint8_t {
    kMono8,
    kBayerRggb8,  ///< named after the first pixels of the first two rows, as in sensor_msgs
    kBayerBggr8,
    kBayerGbrg8,
    kBayerGrbg8,
    kBgr8,  ///< interpolated from an rggb mosaic
  };
  Layout layout = Layout::kMono8;
  int jpeg_quality = 0;  ///< 1 to 100: compressed on the way; 0: not
  /// Of a colour sensor's red and blue pixels to white light, against the green ones.
  double red_response = 1.0;
  double blue_response = 1.0;

  void declare(Parameters& params);
  /// Of the sensor's pixel to white light; 1 for a grey sensor.
  double responseAt(int column, int row) const;
};

/// Names of the layouts as in sensor_msgs/image_encodings.h, in the order of the enumeration.
const std::vector<std::string>& layoutNames();

/// CV_8UC1, or CV_8UC3 for kBgr8. An image that went through JPEG is given unpacked.
cv::Mat encode(const MonoImage& image, const ImageEncoding& encoding);

}  // namespace bearing_calibration::core
