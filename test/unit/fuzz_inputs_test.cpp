// The seeds of a harness and some random inputs: nothing that must hold is broken. scripts/fuzz
// looks for more of them.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <vector>

#include "fuzz/harness.h"

namespace bearing_calibration::fuzz {
namespace {

bool runBytes(const std::vector<char>& input) {
  const std::vector<std::uint8_t> bytes(input.begin(), input.end());
  return run(bytes.data(), bytes.size());
}

TEST(FuzzInputs, SeedsBreakNothing) {
  int far = 0;
  int seeds = 0;
  for (const auto& entry : std::filesystem::directory_iterator(FUZZ_SEEDS)) {
    std::ifstream file(entry.path(), std::ios::binary);
    SCOPED_TRACE(entry.path().string());
    EXPECT_NO_THROW(far += runBytes({std::istreambuf_iterator<char>(file), {}}) ? 1 : 0);
    ++seeds;
  }
  EXPECT_GT(2 * far, seeds) << "most of them are there to come far";
}

TEST(FuzzInputs, RandomBytesBreakNothing) {
  std::mt19937 random(7);
  constexpr std::size_t kMostBytes = 100;
  for (int i = 0; i < FUZZ_RANDOM_INPUTS; ++i) {
    std::vector<char> input(random() % kMostBytes);
    for (char& byte : input) byte = static_cast<char>(random());
    SCOPED_TRACE(i);
    EXPECT_NO_THROW(runBytes(input));
  }
}

}  // namespace
}  // namespace bearing_calibration::fuzz
