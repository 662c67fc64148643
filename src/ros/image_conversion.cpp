#include "bearing_calibration_ros/image_conversion.h"

#include <sensor_msgs/fill_image.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cstdint>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;
using core::formatted;

constexpr int kNoConversion = -1;

struct Encoding {
  const char* name;
  int type;     ///< OpenCV's, of the pixels as they come
  int to_grey;  ///< OpenCV's code; kNoConversion for grey
  int to_bgr;   ///< kNoConversion for grey, and where nothing is to be done

  std::size_t bytesPerPixel() const { return CV_ELEM_SIZE(type); }
  bool isEightBits() const { return CV_MAT_DEPTH(type) == CV_8U; }
};

// OpenCV names a mosaic after the second row's second and third pixel, ROS after the first row.
// Not every sensor_msgs has a name for yuv422_yuy2.
constexpr Encoding kEncodings[] = {
    {"mono8", CV_8UC1, kNoConversion, kNoConversion},
    {"8UC1", CV_8UC1, kNoConversion, kNoConversion},
    {"mono16", CV_16UC1, kNoConversion, kNoConversion},
    {"16UC1", CV_16UC1, kNoConversion, kNoConversion},
    {"bgr8", CV_8UC3, cv::COLOR_BGR2GRAY, kNoConversion},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2GRAY, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2GRAY, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGB2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY, cv::COLOR_YUV2BGR_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2, cv::COLOR_YUV2BGR_YUY2},
};

const Encoding* find(const std::string& name) {
  const auto found = std::find_if(std::begin(kEncodings), std::end(kEncodings),
                                  [&](const Encoding& encoding) { return encoding.name == name; });
  return found == std::end(kEncodings) ? nullptr : found;
}

std::string supportedEncodings() {
  std::vector<std::string> names;
  for (const Encoding& encoding : kEncodings) names.emplace_back(encoding.name);
  return core::joined(names, ", ");
}

std::optional<Refusal> layoutRefusal(const sensor_msgs::Image& image) {
  if (image.width == 0 || image.height == 0 || image.data.empty()) {
    return Refusal{"empty", formatted("it is %ux%u with %zu bytes", image.width, image.height,
                                      image.data.size())};
  }
  const Encoding* encoding = find(image.encoding);
  if (encoding == nullptr) {
    return Refusal{"unsupported encoding", "encoding '" + image.encoding + "' is not one of (" +
                                               supportedEncodings() + ")"};
  }
  const std::size_t row_bytes = image.width * encoding->bytesPerPixel();
  if (image.step < row_bytes) {
    return Refusal{"short rows",
                   formatted("step %u is less than the %zu bytes of a row", image.step, row_bytes)};
  }
  if (!encoding->isEightBits() && image.step % 2 != 0) {
    return Refusal{"odd rows", formatted("step %u is odd, but encoding '%s' has two bytes in "
                                         "a pixel",
                                         image.step, encoding->name)};
  }
  const std::size_t wanted_bytes = static_cast<std::size_t>(image.step) * image.height;
  if (image.data.size() != wanted_bytes) {
    return Refusal{"truncated", formatted("it has %zu bytes instead of step * height = %zu",
                                          image.data.size(), wanted_bytes)};
  }
  return std::nullopt;
}

/// The message's own pixels.
cv::Mat pixelsOf(const sensor_msgs::Image& image, int type) {
  return {static_cast<int>(image.height), static_cast<int>(image.width), type,
          const_cast<std::uint8_t*>(image.data.data()), image.step};
}

/// Pixels of two bytes, the high one first.
void readBigEndian(const sensor_msgs::Image& image, cv::Mat* pixels) {
  pixels->create(static_cast<int>(image.height), static_cast<int>(image.width), CV_16UC1);
  for (int v = 0; v < pixels->rows; ++v) {
    const std::uint8_t* bytes = &image.data[static_cast<std::size_t>(v) * image.step];
    for (int u = 0; u < pixels->cols; ++u, bytes += 2) {
      pixels->at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(bytes[0] << 8U | bytes[1]);
    }
  }
}

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

sensor_msgs::ImagePtr imageMessage(const std_msgs::Header& header, const std::string& encoding,
                                   const cv::Mat& pixels) {
  const cv::Mat whole = pixels.isContinuous() ? pixels : pixels.clone();
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header = header;
  sensor_msgs::fillImage(*image, encoding, static_cast<std::uint32_t>(whole.rows),
                         static_cast<std::uint32_t>(whole.cols),
                         static_cast<std::uint32_t>(whole.step), whole.data);
  return image;
}

std::optional<Refusal> refusalOf(const sensor_msgs::Image& image, const core::ImageSensor& sensor) {
  if (const auto refusal = layoutRefusal(image)) return refusal;
  const auto width = static_cast<unsigned>(sensor.width_px);
  const auto height = static_cast<unsigned>(sensor.height_px);
  if (image.width != width || image.height != height) {
    return Refusal{"wrong size",
                   formatted("it is %ux%u, but sensor/width and sensor/height say %ux%u",
                             image.width, image.height, width, height)};
  }
  const bool eight_bits = find(image.encoding)->isEightBits();
  const bool eight_bits_wanted =
      sensor.saturation_level <= std::numeric_limits<std::uint8_t>::max();
  if (eight_bits != eight_bits_wanted) {
    return Refusal{
        "wrong depth",
        formatted("encoding '%s' %s sensor/saturation_level %.0f%s", image.encoding.c_str(),
                  eight_bits ? "cannot reach" : "goes beyond", sensor.saturation_level,
                  eight_bits ? "" : ": state the level of a full pixel, of 12 bits 4095")};
  }
  if (image.header.stamp.isZero()) {
    return Refusal{"zero stamp", "its stamp is zero: the moment of the exposure is unknown"};
  }
  return std::nullopt;
}

sensor_msgs::ImagePtr decoded(const sensor_msgs::CompressedImage& compressed) {
  const cv::Mat pixels = pixelsOf(compressed);
  if (pixels.empty()) return nullptr;
  const std::string encoding = encodingOf(pixels, compressed.format);
  if (encoding.empty()) return nullptr;
  return imageMessage(compressed.header, encoding, pixels);
}

std::string describeUndecoded(const sensor_msgs::CompressedImage& compressed) {
  return formatted("its %zu bytes of the format '%s' are no jpeg or png of 1, 3 or 4 channels",
                   compressed.data.size(), compressed.format.c_str());
}

bool hasColours(const std::string& name) {
  const Encoding* encoding = find(name);
  return encoding != nullptr && encoding->to_grey != kNoConversion;
}

const cv::Mat& GreyConverter::take(const sensor_msgs::ImageConstPtr& image) {
  const Encoding* encoding = find(image->encoding);
  if (encoding == nullptr) {
    throw std::invalid_argument("unsupported image encoding '" + image->encoding + "'");
  }
  shared_ = image;
  if (!encoding->isEightBits() && image->is_bigendian != 0) {
    readBigEndian(*image, &swapped_);
    pixels_ = swapped_;
  } else {
    pixels_ = pixelsOf(*image, encoding->type);
  }
  return pixels_;
}

const cv::Mat& GreyConverter::convert(const sensor_msgs::ImageConstPtr& image) {
  const cv::Mat& pixels = take(image);
  const int to_grey = find(image->encoding)->to_grey;
  if (to_grey == kNoConversion) return pixels;
  cv::cvtColor(pixels, converted_, to_grey);
  return converted_;
}

const cv::Mat& GreyConverter::convertToColour(const sensor_msgs::ImageConstPtr& image,
                                              double full_levels) {
  if (!hasColours(image->encoding)) {
    throw std::invalid_argument("colour/use is set, but encoding '" + image->encoding +
                                "' has no colours");
  }
  const cv::Mat& pixels = take(image);
  const int to_bgr = find(image->encoding)->to_bgr;
  if (to_bgr == kNoConversion) return pixels;
  cv::cvtColor(pixels, colour_, to_bgr);
  if (colour_.depth() == CV_8U) return colour_;
  colour_.convertTo(scaled_, CV_8U, std::numeric_limits<std::uint8_t>::max() / full_levels);
  return scaled_;
}

}  // namespace bearing_calibration_ros
