#include "bearing_calibration_ros/image_conversion.h"

#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <opencv2/core.hpp>

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;

constexpr int kWidth = 8;
constexpr int kHeight = 6;

bearing_calibration::core::ImageSensor smallSensor() {
  bearing_calibration::core::ImageSensor sensor;
  sensor.width_px = kWidth;
  sensor.height_px = kHeight;
  sensor.saturation_level = 255.0;
  return sensor;
}

/// Each pixel is `pixel`, byte by byte.
sensor_msgs::Image imageOf(const std::string& encoding, const std::vector<std::uint8_t>& pixel) {
  sensor_msgs::Image image;
  image.header.stamp = ros::Time(1, 0);
  image.width = kWidth;
  image.height = kHeight;
  image.encoding = encoding;
  image.step = static_cast<std::uint32_t>(kWidth * pixel.size());
  for (int i = 0; i < kWidth * kHeight; ++i) {
    image.data.insert(image.data.end(), pixel.begin(), pixel.end());
  }
  return image;
}

cv::Mat greyOf(const sensor_msgs::Image& image) {
  GreyConverter converter;
  return converter.convert(boost::make_shared<sensor_msgs::Image>(image)).clone();
}

std::string refusedAs(const sensor_msgs::Image& image) {
  const auto refusal = refusalOf(image, smallSensor());
  return refusal ? refusal->kind : "";
}

// ITU-R BT.601: grey = 0.299 red + 0.587 green + 0.114 blue.
TEST(ImageConversion, ColoursAreWeightedInTheOrderOfTheEncoding) {
  constexpr int kRedGrey = 60;  // of 200
  constexpr int kBlueGrey = 23;
  EXPECT_NEAR(greyOf(imageOf(encodings::RGB8, {200, 0, 0})).at<std::uint8_t>(3, 3), kRedGrey, 1);
  EXPECT_NEAR(greyOf(imageOf(encodings::BGR8, {200, 0, 0})).at<std::uint8_t>(3, 3), kBlueGrey, 1);
  EXPECT_NEAR(greyOf(imageOf(encodings::RGBA8, {200, 0, 0, 255})).at<std::uint8_t>(3, 3), kRedGrey,
              1);
  EXPECT_NEAR(greyOf(imageOf(encodings::BGRA8, {200, 0, 0, 255})).at<std::uint8_t>(3, 3), kBlueGrey,
              1);
}

/// A mosaic in which the red pixels alone are lit; the first row's first pixel is (0, 0).
cv::Mat greyOfRedMosaic(const std::string& encoding, int red_u, int red_v) {
  sensor_msgs::Image image = imageOf(encoding, {0});
  for (int v = red_v; v < kHeight; v += 2) {
    for (int u = red_u; u < kWidth; u += 2) {
      image.data[static_cast<std::size_t>(v * kWidth + u)] = 200;
    }
  }
  return greyOf(image);
}

TEST(ImageConversion, AMosaicsRedIsWhereTheEncodingSays) {
  constexpr int kRedGrey = 60;
  EXPECT_NEAR(greyOfRedMosaic(encodings::BAYER_RGGB8, 0, 0).at<std::uint8_t>(3, 3), kRedGrey, 2);
  EXPECT_NEAR(greyOfRedMosaic(encodings::BAYER_GRBG8, 1, 0).at<std::uint8_t>(3, 3), kRedGrey, 2);
  EXPECT_NEAR(greyOfRedMosaic(encodings::BAYER_GBRG8, 0, 1).at<std::uint8_t>(3, 3), kRedGrey, 2);
  EXPECT_NEAR(greyOfRedMosaic(encodings::BAYER_BGGR8, 1, 1).at<std::uint8_t>(3, 3), kRedGrey, 2);
}

TEST(ImageConversion, AMosaicOfSixteenBitsKeepsThem) {
  constexpr int kRed = 4000;
  for (const bool is_bigendian : {false, true}) {
    sensor_msgs::Image image = imageOf(encodings::BAYER_RGGB16, {0, 0});
    image.is_bigendian = is_bigendian ? 1 : 0;
    for (int v = 0; v < kHeight; v += 2) {
      for (int u = 0; u < kWidth; u += 2) {
        std::uint8_t* pixel = &image.data[static_cast<std::size_t>(2 * (v * kWidth + u))];
        pixel[is_bigendian ? 1 : 0] = kRed % 256;
        pixel[is_bigendian ? 0 : 1] = kRed / 256;
      }
    }
    const cv::Mat grey = greyOf(image);
    ASSERT_EQ(grey.type(), CV_16UC1);
    EXPECT_NEAR(grey.at<std::uint16_t>(3, 3), 0.299 * kRed, 2);
    GreyConverter converter;
    const cv::Vec3b colour = converter
                                 .convertToColour(boost::make_shared<sensor_msgs::Image>(image),
                                                  static_cast<double>(kRed))
                                 .at<cv::Vec3b>(3, 3);
    EXPECT_EQ(colour, cv::Vec3b(0, 0, 255)) << "as parts of a full pixel";
  }
}

// ITU-R BT.601: Y of 81, U of 90 and V of 240 are pure red.
TEST(ImageConversion, YuvIsInTheOrderOfTheEncoding) {
  for (const auto& [encoding, pair] :
       {std::pair<std::string, std::vector<std::uint8_t>>{encodings::YUV422, {90, 81, 240, 81}},
        {"yuv422_yuy2", {81, 90, 81, 240}}}) {
    sensor_msgs::Image image = imageOf(encoding, {0, 0});
    for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = pair[i % 4];
    EXPECT_EQ(refusedAs(image), "") << encoding;
    const cv::Mat grey = greyOf(image);
    ASSERT_EQ(grey.type(), CV_8UC1);
    EXPECT_EQ(grey.at<std::uint8_t>(3, 3), 81) << encoding;
    GreyConverter converter;
    const cv::Vec3b colour =
        converter.convertToColour(boost::make_shared<sensor_msgs::Image>(image), 255.0)
            .at<cv::Vec3b>(3, 3);
    EXPECT_NEAR(colour[0], 0, 2);
    EXPECT_NEAR(colour[1], 0, 2);
    EXPECT_NEAR(colour[2], 255, 2);
  }
}

TEST(ImageConversion, GreyIsSharedNotCopied) {
  for (const auto& [encoding, bytes] :
       {std::pair<std::string, int>{encodings::MONO8, 1}, {encodings::MONO16, 2}}) {
    const auto image = boost::make_shared<sensor_msgs::Image>(
        imageOf(encoding, std::vector<std::uint8_t>(static_cast<std::size_t>(bytes), 7)));
    GreyConverter converter;
    EXPECT_EQ(converter.convert(image).data, image->data.data()) << encoding;
  }
}

TEST(ImageConversion, TheOrderOfBytesIsTheMessages) {
  sensor_msgs::Image image = imageOf(encodings::MONO16, {0x01, 0x02});
  EXPECT_EQ(greyOf(image).at<std::uint16_t>(2, 2), 0x0201);
  image.is_bigendian = 1;
  ASSERT_EQ(greyOf(image).type(), CV_16UC1);
  EXPECT_EQ(greyOf(image).at<std::uint16_t>(2, 2), 0x0102);
}

TEST(ImageConversion, PixelsBecomeAMessageAlsoWhereTheyArePartOfOthers) {
  cv::Mat all(kHeight + 2, kWidth + 3, CV_16UC1);
  for (int i = 0; i < static_cast<int>(all.total()); ++i) {
    all.at<std::uint16_t>(i / all.cols, i % all.cols) = static_cast<std::uint16_t>(257 * i);
  }
  const cv::Mat part = all(cv::Rect(3, 1, kWidth, kHeight));
  std_msgs::Header header;
  header.frame_id = "camera";
  header.stamp = ros::Time(1, 0);
  const sensor_msgs::ImagePtr image = imageMessage(header, encodings::MONO16, part);
  bearing_calibration::core::ImageSensor sensor = smallSensor();
  sensor.saturation_level = 65535.0;
  EXPECT_FALSE(refusalOf(*image, sensor));
  EXPECT_EQ(image->data.size(), part.total() * part.elemSize()) << "none of the others";
  EXPECT_EQ(image->header.frame_id, "camera");
  EXPECT_EQ(cv::countNonZero(greyOf(*image) != part), 0);
}

TEST(ImageConversion, EachFaultHasItsName) {
  const sensor_msgs::Image good = imageOf(encodings::MONO8, {7});
  EXPECT_EQ(refusedAs(good), "");
  sensor_msgs::Image image = good;
  image.data.clear();
  EXPECT_EQ(refusedAs(image), "empty");
  image = good;
  image.data.pop_back();
  EXPECT_EQ(refusedAs(image), "truncated");
  image = good;
  image.step = kWidth - 1;
  EXPECT_EQ(refusedAs(image), "short rows");
  image = good;
  image.encoding = "bgr16";
  EXPECT_EQ(refusedAs(image), "unsupported encoding");
  image = imageOf(encodings::MONO16, {0x01, 0x02});
  image.step += 1;
  EXPECT_EQ(refusedAs(image), "odd rows");
  image = good;
  image.width = kWidth - 1;
  EXPECT_EQ(refusedAs(image), "wrong size");
  image = good;
  image.header.stamp = ros::Time();
  EXPECT_EQ(refusedAs(image), "zero stamp");
}

// 2^16 rows of 2^16 bytes do not fit 32 bits: the product must not wrap to what is there.
// Promise refused: an image whose size overflows
TEST(ImageConversion, AnAbsurdSizeDoesNotWrap) {
  sensor_msgs::Image image = imageOf(encodings::MONO8, {7});
  image.step = 1u << 16;
  image.height = 1u << 16;
  EXPECT_EQ(refusedAs(image), "truncated");
  image.width = 0xffffffffu;
  image.encoding = encodings::BGR8;
  EXPECT_EQ(refusedAs(image), "short rows");
}

TEST(ImageConversion, ADepthThatCannotSaturateIsRefused) {
  bearing_calibration::core::ImageSensor sensor = smallSensor();
  sensor.saturation_level = 4095.0;
  EXPECT_EQ(refusalOf(imageOf(encodings::MONO8, {7}), sensor)->kind, "wrong depth");
  EXPECT_EQ(refusalOf(imageOf(encodings::BGR8, {7, 7, 7}), sensor)->kind, "wrong depth");
  EXPECT_FALSE(refusalOf(imageOf(encodings::MONO16, {7, 0}), sensor));
  EXPECT_EQ(refusalOf(imageOf(encodings::YUV422, {7, 7}), sensor)->kind, "wrong depth");
  EXPECT_FALSE(refusalOf(imageOf(encodings::BAYER_GRBG16, {7, 0}), sensor));
}

// All of an image of 12 bits would count as full.
TEST(ImageConversion, ADepthBeyondSaturationIsRefused) {
  EXPECT_EQ(refusedAs(imageOf(encodings::MONO16, {7, 7})), "wrong depth");
  EXPECT_EQ(refusedAs(imageOf(encodings::BAYER_GRBG16, {7, 7})), "wrong depth");
}

}  // namespace
}  // namespace bearing_calibration_ros
