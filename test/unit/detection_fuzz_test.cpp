// Images that no driver should send, through the fuzzer's harness: messages, never a crash.
// scripts/fuzz looks for more of them.

#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include "fuzz/detection_fuzzer.h"

namespace bearing_calibration_ros {
namespace {

namespace encodings = sensor_msgs::image_encodings;

sensor_msgs::Image mono(std::uint32_t width, std::uint32_t height, std::uint8_t level) {
  sensor_msgs::Image image;
  image.header.stamp.sec = 1;
  image.width = width;
  image.height = height;
  image.step = width;
  image.encoding = encodings::MONO8;
  image.data.assign(static_cast<std::size_t>(width) * height, level);
  return image;
}

TEST(BadImages, AreRefused) {
  DetectionFuzzer fuzzer;
  EXPECT_FALSE(fuzzer.see(sensor_msgs::Image()));
  EXPECT_FALSE(fuzzer.see(mono(0, 480, 0)));
  sensor_msgs::Image wrong = mono(640, 480, 0);
  wrong.encoding = "yuv422";
  EXPECT_FALSE(fuzzer.see(wrong));
  sensor_msgs::Image truncated = mono(640, 480, 0);
  truncated.data.pop_back();
  EXPECT_FALSE(fuzzer.see(truncated));
  sensor_msgs::Image narrow = mono(640, 480, 0);
  narrow.encoding = encodings::BGR8;
  EXPECT_FALSE(fuzzer.see(narrow));
}

TEST(EmptyImages, AreSearchedAndHoldNothing) {
  for (std::uint8_t level : {0, 255}) {
    EXPECT_TRUE(DetectionFuzzer().see(mono(640, 480, level)));
    EXPECT_TRUE(DetectionFuzzer().see(mono(1, 1, level)));
    EXPECT_TRUE(DetectionFuzzer().see(mono(16384, 40, level)));
    EXPECT_TRUE(DetectionFuzzer().see(mono(2, 16384, level)));
  }
}

}  // namespace
}  // namespace bearing_calibration_ros
