#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <opencv2/imgcodecs.hpp>

#include "bearing_calibration_ros/image_conversion.h"

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;

sensor_msgs::CompressedImage compressedFrom(const cv::Mat& pixels, const std::string& format,
                                            const std::string& extension = ".png") {
  sensor_msgs::CompressedImage compressed;
  compressed.header.stamp = ros::Time(12, 34);
  compressed.header.frame_id = "lens";
  compressed.format = format;
  cv::imencode(extension, pixels, compressed.data);
  return compressed;
}

TEST(CompressedImage, KeepsHeaderPixelsAndDepth) {
  const cv::Mat grey = (cv::Mat_<std::uint8_t>(2, 3) << 1, 2, 3, 4, 5, 6);
  const auto image = decoded(compressedFrom(grey, "mono8; png compressed "));
  ASSERT_TRUE(image);
  EXPECT_EQ(image->header.stamp, ros::Time(12, 34));
  EXPECT_EQ(image->header.frame_id, "lens");
  EXPECT_EQ(image->encoding, encodings::MONO8);
  EXPECT_EQ(image->width, 3u);
  EXPECT_EQ(image->data, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6}));

  const auto deep = decoded(compressedFrom(cv::Mat(2, 2, CV_16UC1, cv::Scalar(0x0302)), "png"));
  ASSERT_TRUE(deep);
  EXPECT_EQ(deep->encoding, encodings::MONO16);
  EXPECT_EQ(deep->data[0] + 256 * deep->data[1], 0x0302);
}

TEST(CompressedImage, ColoursAreBlueFirstAndAMosaicIsOne) {
  const cv::Mat blue(2, 2, CV_8UC3, cv::Scalar(200, 0, 0));
  const auto colour = decoded(compressedFrom(blue, "rgb8; jpeg compressed bgr8", ".jpg"));
  ASSERT_TRUE(colour);
  EXPECT_EQ(colour->encoding, encodings::BGR8);
  EXPECT_GT(colour->data[0], 150);
  EXPECT_LT(colour->data[2], 50);

  const cv::Mat mosaic(2, 2, CV_8UC1, cv::Scalar(9));
  EXPECT_EQ(decoded(compressedFrom(mosaic, "bayer_grbg8; png compressed "))->encoding,
            encodings::BAYER_GRBG8);
  // what a plugin has made grey is none any more
  EXPECT_EQ(decoded(compressedFrom(blue, "bayer_grbg8; png compressed bgr8"))->encoding,
            encodings::BGR8);
}

TEST(CompressedImage, WhatIsNoImageIsNull) {
  sensor_msgs::CompressedImage compressed;
  EXPECT_FALSE(decoded(compressed));
  compressed.data.assign(1000, 7);
  EXPECT_FALSE(decoded(compressed));
  compressed = compressedFrom(cv::Mat(2, 2, CV_16UC3, cv::Scalar::all(1)), "png");
  EXPECT_FALSE(decoded(compressed)) << "three channels of 16 bits";
}

}  // namespace
}  // namespace bearing_calibration_ros
