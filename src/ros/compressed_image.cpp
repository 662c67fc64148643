#include "bearing_calibration_ros/compressed_image.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <opencv2/imgcodecs.hpp>
#include <string>

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;

/// Of the decoded pixels; empty for what no camera sends. `format` begins with the encoding before
/// the compression, where image_transport's plugin has written it: "bayer_rggb8; png compressed ".
std::string encodingOf(const cv::Mat& image, const std::string& format) {
  const std::string before = format.substr(0, format.find(';'));
  const bool is_mosaic = encodings::isBayer(before) &&
                         encodings::bitDepth(before) == 8 * static_cast<int>(image.elemSize1());
  switch (image.type()) {
    case CV_8UC1:
      return is_mosaic ? before : encodings::MONO8;
    case CV_16UC1:
      return is_mosaic ? before : encodings::MONO16;
    case CV_8UC3:
      return encodings::BGR8;
    case CV_8UC4:
      return encodings::BGRA8;
    default:
      return {};
  }
}

cv::Mat pixelsOf(const sensor_msgs::CompressedImage& compressed) {
  if (compressed.data.empty()) return {};
  try {
    return cv::imdecode(compressed.data, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {  // a header that promises more than there can be
    return {};
  }
}

}  // namespace

sensor_msgs::ImagePtr decoded(const sensor_msgs::CompressedImage& compressed) {
  const cv::Mat pixels = pixelsOf(compressed);
  if (pixels.empty()) return nullptr;
  const std::string encoding = encodingOf(pixels, compressed.format);
  if (encoding.empty()) return nullptr;
  return cv_bridge::CvImage(compressed.header, encoding, pixels).toImageMsg();
}

std::string describeUndecoded(const sensor_msgs::CompressedImage& compressed) {
  return "its " + std::to_string(compressed.data.size()) + " bytes of the format '" +
         compressed.format + "' are no jpeg or png of 1, 3 or 4 channels";
}

}  // namespace bearing_calibration_ros
