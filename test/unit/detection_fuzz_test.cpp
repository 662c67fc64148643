// Images that no driver should send, through the fuzzer's harness: messages, never a crash.
// scripts/fuzz looks for more of them.

#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

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
  EXPECT_FALSE(fuzzer.run(sensor_msgs::Image()));
  EXPECT_FALSE(fuzzer.run(mono(0, 480, 0)));
  sensor_msgs::Image wrong = mono(640, 480, 0);
  wrong.encoding = "yuv422";
  EXPECT_FALSE(fuzzer.run(wrong));
  sensor_msgs::Image truncated = mono(640, 480, 0);
  truncated.data.pop_back();
  EXPECT_FALSE(fuzzer.run(truncated));
  sensor_msgs::Image narrow = mono(640, 480, 0);
  narrow.encoding = encodings::BGR8;
  EXPECT_FALSE(fuzzer.run(narrow));
}

TEST(EmptyImages, AreSearchedAndHoldNothing) {
  DetectionFuzzer fuzzer;
  for (std::uint8_t level : {0, 255}) {
    EXPECT_TRUE(fuzzer.run(mono(640, 480, level)));
    EXPECT_TRUE(fuzzer.run(mono(1, 1, level)));
    EXPECT_TRUE(fuzzer.run(mono(16384, 40, level)));
    EXPECT_TRUE(fuzzer.run(mono(2, 16384, level)));
  }
}

TEST(Seeds, LeadToNoMeaninglessResult) {
  DetectionFuzzer fuzzer;
  int searched = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FUZZ_SEEDS)) {
    std::ifstream file(entry.path(), std::ios::binary);
    const std::vector<char> input{std::istreambuf_iterator<char>(file), {}};
    const std::vector<std::uint8_t> bytes(input.begin(), input.end());
    searched += fuzzer.run(bytes.data(), bytes.size()) ? 1 : 0;
  }
  EXPECT_EQ(searched, 5);  // one of them is truncated
}

TEST(RandomInputs, LeadToNoMeaninglessResult) {
  DetectionFuzzer fuzzer;
  std::mt19937 random(7);
  constexpr int kInputs = 500;
  constexpr std::size_t kMostBytes = 100;
  int searched = 0;
  for (int i = 0; i < kInputs; ++i) {
    std::vector<std::uint8_t> input(random() % kMostBytes);
    for (std::uint8_t& byte : input) byte = static_cast<std::uint8_t>(random());
    searched += fuzzer.run(input.data(), input.size()) ? 1 : 0;
  }
  EXPECT_GT(searched, kInputs / 20);  // the others have a flaw
}

}  // namespace
}  // namespace bearing_calibration_ros
