#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "bearing_calibration/odometry/wheel_readings.h"

namespace bearing_calibration::core {
namespace {

constexpr double kMaxApart_s = 0.2;
constexpr int kBits = 16;

Stamp at(double seconds) { return stampFromSeconds(100.0 + seconds); }

class WheelPairingTest : public ::testing::Test {
 protected:
  PairingOutcome left(double seconds, std::int64_t ticks) {
    return pairing_.add(WheelSide::kLeft, {at(seconds), ticks});
  }
  PairingOutcome right(double seconds, std::int64_t ticks) {
    return pairing_.add(WheelSide::kRight, {at(seconds), ticks});
  }

  WheelPairing pairing_{kBits, kMaxApart_s};
};

void expectPair(const PairingOutcome& outcome, double seconds, std::int64_t left,
                std::int64_t right) {
  ASSERT_EQ(outcome.pairs.size(), 1U);
  EXPECT_EQ(outcome.pairs.front().stamp, at(seconds));
  EXPECT_EQ(outcome.pairs.front().left_ticks, left);
  EXPECT_EQ(outcome.pairs.front().right_ticks, right);
  EXPECT_TRUE(outcome.refused.empty());
}

void expectRefused(const PairingOutcome& outcome, InputStatus status, double value) {
  EXPECT_TRUE(outcome.pairs.empty());
  ASSERT_EQ(outcome.refused.size(), 1U);
  EXPECT_EQ(outcome.refused.front().status, status) << nameOf(outcome.refused.front().status);
  EXPECT_NEAR(outcome.refused.front().value, value, 1e-6);
}

TEST_F(WheelPairingTest, ReadingsOfOneMomentArePairedAtOnceInEitherOrder) {
  EXPECT_TRUE(left(0.0, 7).pairs.empty());
  expectPair(right(0.0, 9), 0.0, 7, 9);
  EXPECT_TRUE(right(0.1, 12).pairs.empty());
  expectPair(left(0.1, 8), 0.1, 8, 12);
}

TEST_F(WheelPairingTest, TheRightCounterIsInterpolatedAtTheLeftMoment) {
  right(0.0, 100);
  EXPECT_TRUE(left(0.025, 7).pairs.empty());
  expectPair(right(0.1, 140), 0.025, 7, 110);
}

TEST_F(WheelPairingTest, InterpolationGoesAcrossTheWrapInBothDirections) {
  right(0.0, 65530);
  left(0.05, 1);
  const PairingOutcome forward = right(0.1, 10);  // 16 ticks on
  ASSERT_EQ(forward.pairs.size(), 1U);
  EXPECT_EQ(wrappedTickDifference(65530, forward.pairs.front().right_ticks, kBits), 8);
  EXPECT_TRUE(fitsCounter(forward.pairs.front().right_ticks, kBits));
  left(0.15, 2);
  const PairingOutcome backward = right(0.2, 65526);  // 20 ticks back
  ASSERT_EQ(backward.pairs.size(), 1U);
  EXPECT_EQ(wrappedTickDifference(10, backward.pairs.front().right_ticks, kBits), -10);
}

TEST_F(WheelPairingTest, InterpolationGoesAcrossTheWrapOf64Bits) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  WheelPairing pairing(64, kMaxApart_s);
  pairing.add(WheelSide::kRight, {at(0.0), kMost - 9});
  pairing.add(WheelSide::kLeft, {at(0.075), 1});
  expectPair(pairing.add(WheelSide::kRight, {at(0.1), kLeast + 10}), 0.075, 1, kLeast + 5);
}

TEST_F(WheelPairingTest, OneRightReadingMayCompleteSeveralLeftOnes) {
  right(0.0, 0);
  for (const double seconds : {0.05, 0.1, 0.15}) left(seconds, 0);
  const PairingOutcome outcome = right(0.2, 200);
  ASSERT_EQ(outcome.pairs.size(), 3U);
  EXPECT_EQ(outcome.pairs[0].right_ticks, 50);
  EXPECT_EQ(outcome.pairs[2].right_ticks, 150);
}

TEST_F(WheelPairingTest, AGapOfTheOtherWheelLeavesReadingsOut) {
  right(0.0, 0);
  left(0.1, 0);
  expectRefused(right(0.5, 100), InputStatus::kNoPartner, 0.5);
  left(0.55, 1);
  expectPair(right(0.6, 200), 0.55, 1, 150);
}

// Promise bounded: a wheel that never reports
TEST_F(WheelPairingTest, WhatNeverComesIsSaidAfterAWhileAndMemoryStaysBounded) {
  int refused = 0;
  constexpr int kReadings = 1000;
  constexpr double kPeriod_s = 0.1;
  for (int i = 0; i < kReadings; ++i) {
    const PairingOutcome outcome = left(kPeriod_s * i, i);
    EXPECT_TRUE(outcome.pairs.empty());
    for (const InputOutcome& one : outcome.refused) {
      EXPECT_EQ(one.status, InputStatus::kNoPartner);
      EXPECT_NEAR(one.value, WheelPairing::kLongestWait_s + kPeriod_s, 1e-6);
    }
    refused += static_cast<int>(outcome.refused.size());
  }
  EXPECT_EQ(refused, kReadings - 1 - static_cast<int>(WheelPairing::kLongestWait_s / kPeriod_s));
}

TEST_F(WheelPairingTest, RightReadingsWithoutLeftOnesAreSaidToo) {
  EXPECT_TRUE(right(0.0, 0).refused.empty());
  EXPECT_TRUE(right(4.9, 0).refused.empty());
  expectRefused(right(5.1, 0), InputStatus::kNoPartner, 5.1);
}

TEST_F(WheelPairingTest, BadReadingsAreRefused) {
  left(0.0, 0);
  right(0.0, 0);
  expectRefused(left(-0.5, 0), InputStatus::kStampNotAfterLast, 0.5);
  expectRefused(right(0.0, 0), InputStatus::kStampNotAfterLast, 0.0);
  expectRefused(left(0.1, 65536), InputStatus::kTicksOutOfRange, 65536.0);
  expectRefused(pairing_.add(WheelSide::kLeft, {Stamp(), 0}), InputStatus::kNoStamp, 0.0);
  left(0.1, 4);
  expectPair(right(0.1, 5), 0.1, 4, 5);
}

}  // namespace
}  // namespace bearing_calibration::core
