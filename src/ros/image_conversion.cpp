#include "bearing_calibration_ros/image_conversion.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;

constexpr int kNoConversion = -1;

struct Encoding {
  const std::string* name;
  std::size_t bytes_per_pixel;
  int to_grey;  ///< OpenCV's code; kNoConversion for grey
  int to_bgr;   ///< kNoConversion for grey, and where nothing is to be done
};

// OpenCV names a mosaic after the second row's second and third pixel, ROS after the first row.
const Encoding kEncodings[] = {
    {&encodings::MONO8, 1, kNoConversion, kNoConversion},
    {&encodings::TYPE_8UC1, 1, kNoConversion, kNoConversion},
    {&encodings::MONO16, 2, kNoConversion, kNoConversion},
    {&encodings::TYPE_16UC1, 2, kNoConversion, kNoConversion},
    {&encodings::BGR8, 3, cv::COLOR_BGR2GRAY, kNoConversion},
    {&encodings::RGB8, 3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {&encodings::BGRA8, 4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {&encodings::RGBA8, 4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    {&encodings::BAYER_RGGB8, 1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {&encodings::BAYER_BGGR8, 1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {&encodings::BAYER_GBRG8, 1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {&encodings::BAYER_GRBG8, 1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
};

const Encoding* find(const std::string& name) {
  const auto found = std::find_if(std::begin(kEncodings), std::end(kEncodings),
                                  [&](const Encoding& encoding) { return *encoding.name == name; });
  return found == std::end(kEncodings) ? nullptr : found;
}

std::string supportedEncodings() {
  std::string list;
  for (const Encoding& encoding : kEncodings) list += (list.empty() ? "" : ", ") + *encoding.name;
  return list;
}

std::string sizeText(std::size_t width, std::size_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool isEightBits(const Encoding& encoding) {
  return encoding.to_grey != kNoConversion || encoding.bytes_per_pixel == 1;
}

std::optional<ImageRefusal> layoutRefusal(const sensor_msgs::Image& image) {
  if (image.width == 0 || image.height == 0 || image.data.empty()) {
    return ImageRefusal{"empty", "it is " + sizeText(image.width, image.height) + " with " +
                                     std::to_string(image.data.size()) + " bytes"};
  }
  const Encoding* encoding = find(image.encoding);
  if (encoding == nullptr) {
    return ImageRefusal{
        "unsupported encoding",
        "encoding '" + image.encoding + "' is not one of (" + supportedEncodings() + ")"};
  }
  const std::size_t row_bytes = image.width * encoding->bytes_per_pixel;
  if (image.step < row_bytes) {
    return ImageRefusal{"short rows", "step " + std::to_string(image.step) + " is less than the " +
                                          std::to_string(row_bytes) + " bytes of a row"};
  }
  if (!isEightBits(*encoding) && image.step % 2 != 0) {
    return ImageRefusal{"odd rows", "step " + std::to_string(image.step) +
                                        " is odd, but encoding '" + image.encoding +
                                        "' has two bytes in a pixel"};
  }
  const std::size_t wanted_bytes = static_cast<std::size_t>(image.step) * image.height;
  if (image.data.size() != wanted_bytes) {
    return ImageRefusal{"truncated",
                        "it has " + std::to_string(image.data.size()) +
                            " bytes instead of step * height = " + std::to_string(wanted_bytes)};
  }
  return std::nullopt;
}

/// Pixels of two bytes, the high one first. (cv_bridge 1.16 makes two channels of them.)
void readBigEndian(const sensor_msgs::Image& image, cv::Mat* grey) {
  grey->create(static_cast<int>(image.height), static_cast<int>(image.width), CV_16UC1);
  for (int v = 0; v < grey->rows; ++v) {
    const std::uint8_t* bytes = &image.data[static_cast<std::size_t>(v) * image.step];
    for (int u = 0; u < grey->cols; ++u, bytes += 2) {
      grey->at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(bytes[0] << 8U | bytes[1]);
    }
  }
}

}  // namespace

std::optional<ImageRefusal> refusalOf(const sensor_msgs::Image& image,
                                      const bearing_calibration::ImageSensor& sensor) {
  if (const auto refusal = layoutRefusal(image)) return refusal;
  const bool fits = image.width == static_cast<std::size_t>(sensor.width_px) &&
                    image.height == static_cast<std::size_t>(sensor.height_px);
  if (!fits) {
    return ImageRefusal{"wrong size", "it is " + sizeText(image.width, image.height) +
                                          ", but sensor/width and sensor/height say " +
                                          sizeText(static_cast<std::size_t>(sensor.width_px),
                                                   static_cast<std::size_t>(sensor.height_px))};
  }
  if (isEightBits(*find(image.encoding)) &&
      sensor.saturation_level > std::numeric_limits<std::uint8_t>::max()) {
    return ImageRefusal{"wrong depth", "encoding '" + image.encoding +
                                           "' cannot reach sensor/saturation_level " +
                                           std::to_string(sensor.saturation_level)};
  }
  if (image.header.stamp.isZero()) {
    return ImageRefusal{"zero stamp", "its stamp is zero: the moment of the exposure is unknown"};
  }
  return std::nullopt;
}

bool hasColours(const std::string& name) {
  const Encoding* encoding = find(name);
  return encoding != nullptr && encoding->to_grey != kNoConversion;
}

const cv::Mat& GreyConverter::convert(const sensor_msgs::ImageConstPtr& image) {
  const Encoding* encoding = find(image->encoding);
  if (encoding == nullptr) {
    throw std::invalid_argument("unsupported image encoding '" + image->encoding + "'");
  }
  if (!isEightBits(*encoding) && image->is_bigendian != 0) {
    readBigEndian(*image, &converted_);
    return converted_;
  }
  shared_ = cv_bridge::toCvShare(image);
  if (encoding->to_grey == kNoConversion) return shared_->image;
  cv::cvtColor(shared_->image, converted_, encoding->to_grey);
  return converted_;
}

const cv::Mat& GreyConverter::convertToColour(const sensor_msgs::ImageConstPtr& image) {
  if (!hasColours(image->encoding)) {
    throw std::invalid_argument("colour/use is set, but encoding '" + image->encoding +
                                "' has no colours");
  }
  shared_ = cv_bridge::toCvShare(image);
  const int to_bgr = find(image->encoding)->to_bgr;
  if (to_bgr == kNoConversion) return shared_->image;
  cv::cvtColor(shared_->image, colour_, to_bgr);
  return colour_;
}

}  // namespace bearing_calibration_ros
