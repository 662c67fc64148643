#include "fuzz/image_input.h"

#include <algorithm>
#include <iterator>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

namespace bearing_calibration_ros {
namespace {

using bearing_calibration::fuzz::ByteReader;

struct Size {
  std::uint32_t width;
  std::uint32_t height;
};
constexpr Size kSizes[] = {{0, 0},     {1, 1},     {2, 1},     {1, 480},   {64, 48},
                           {63, 47},   {160, 120}, {320, 240}, {161, 120}, {16384, 2},
                           {2, 16384}, {16384, 8}, {0, 480}};

struct Encoding {
  const char* name;
  std::uint32_t bytes_per_pixel;
};
constexpr Encoding kEncodings[] = {
    {"mono8", 1},       {"8UC1", 1},        {"mono16", 2}, {"16UC1", 2},       {"bgr8", 3},
    {"rgb8", 3},        {"bgra8", 4},       {"rgba8", 4},  {"bayer_rggb8", 1}, {"bayer_bggr8", 1},
    {"bayer_gbrg8", 1}, {"bayer_grbg8", 1}, {"yuv422", 2}, {"32FC1", 4},       {"", 1},
    {"mono8 ", 1}};

enum Flaw : std::uint8_t {
  kShortStep = 1,
  kLongStep = 2,
  kTruncated = 4,
  kTooLong = 8,
  kNoStamp = 16,
  kBigEndian = 32
};

/// Ellipses until the bytes end, each of twelve: as near to spots as they want to be.
void drawEllipses(ByteReader* bytes, cv::Mat* picture) {
  constexpr int kFractionBits = 4;
  while (!bytes->isEmpty()) {
    const int scale = 1 << kFractionBits;
    const cv::Point centre{bytes->word() % (picture->cols * scale + 1),
                           bytes->word() % (picture->rows * scale + 1)};
    const cv::Size axes{bytes->word() % (picture->cols * scale + 1),
                        bytes->word() % (picture->rows * scale + 1)};
    const double turn_deg = bytes->byte();
    const double level = bytes->byte();
    constexpr int kFilled = -1;
    cv::ellipse(*picture, centre, axes, turn_deg, 0.0, 360.0, cv::Scalar::all(level), kFilled,
                cv::LINE_8, kFractionBits);
  }
}

/// What the pixels show, one byte for each of `columns` by `rows`.
cv::Mat pictureFrom(ByteReader* bytes, int columns, int rows) {
  constexpr int kKinds = 4;
  cv::Mat picture(rows, columns, CV_8UC1, cv::Scalar::all(0));
  switch (bytes->byte() % kKinds) {
    case 0:
      picture = cv::Scalar::all(bytes->byte());
      break;
    case 1: {
      std::minstd_rand random(bytes->word() + 1U);
      const unsigned range = bytes->byte() + 1U;
      for (auto pixel = picture.begin<std::uint8_t>(); pixel != picture.end<std::uint8_t>();
           ++pixel) {
        *pixel = static_cast<std::uint8_t>(random() % range);
      }
      break;
    }
    case 2:
      for (auto pixel = picture.begin<std::uint8_t>();
           pixel != picture.end<std::uint8_t>() && !bytes->isEmpty(); ++pixel) {
        *pixel = bytes->byte();
      }
      break;
    default:
      picture = cv::Scalar::all(bytes->byte());
      drawEllipses(bytes, &picture);
  }
  return picture;
}

}  // namespace

sensor_msgs::Image imageFrom(ByteReader* bytes) {
  const Size size = bytes->pick(kSizes);
  const Encoding encoding = bytes->pick(kEncodings);
  const std::uint8_t flaws = bytes->byte();
  sensor_msgs::Image image;
  image.width = size.width;
  image.height = size.height;
  image.encoding = encoding.name;
  image.is_bigendian = (flaws & kBigEndian) != 0 ? 1 : 0;
  image.step = size.width * encoding.bytes_per_pixel;
  if ((flaws & kShortStep) != 0) image.step /= 2;
  if ((flaws & kLongStep) != 0) image.step += 7;
  if ((flaws & kNoStamp) == 0) image.header.stamp.sec = 1;
  const int columns = static_cast<int>(image.step);
  const int rows = static_cast<int>(image.height);
  if (columns > 0 && rows > 0) {
    const cv::Mat picture = pictureFrom(bytes, columns, rows);
    image.data.assign(picture.begin<std::uint8_t>(), picture.end<std::uint8_t>());
  }
  if ((flaws & kTruncated) != 0) image.data.resize(image.data.size() / 2);
  if ((flaws & kTooLong) != 0) image.data.resize(image.data.size() + 1);
  return image;
}

}  // namespace bearing_calibration_ros
