#include "bearing_calibration/vision/blink_identifier.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr double kFrame_s = 1.0 / 30.0;
constexpr double kSpin_radps = 1.0;

BlinkConfig blinkAtFive() {
  BlinkConfig config;
  config.use = true;
  config.rate_hz = 5.0;
  config.window_s = 1.5;
  config.min_part_at_rate = 0.4;
  config.max_turn_rate_radps = 2.0;
  config.light_id = 7;
  return config;
}

/// A light in the world; it blinks evenly on and off, at a rate of 0 it is steady.
struct TestLight {
  double azimuth_rad;
  double rate_hz;
  double on_part = 0.5;

  bool isOn(double time_s) const {
    return rate_hz == 0.0 || std::fmod(time_s * rate_hz, 1.0) < on_part;
  }
};

/// What a spinning sensor sees of the lights, each told by its image radius.
class Spin {
 public:
  Spin(const BlinkConfig& config, const std::vector<TestLight>& lights)
      : identifier_(config), lights_(lights) {}

  /// The set of the next frame, stamps late by a few milliseconds as drivers' are.
  BearingSet next() {
    const double time_s = kFrame_s * ++frame_ + late_(random_);
    BearingSet set;
    set.stamp = stampFromSeconds(100.0 + time_s);
    std::vector<Detection> seen;
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      if (!lights_[i].isOn(time_s)) continue;
      Bearing bearing;
      bearing.azimuth_rad = wrapAngle(lights_[i].azimuth_rad - kSpin_radps * time_s);
      bearing.image_radius_px = static_cast<double>(i);
      set.candidates.push_back(bearing);
      seen.emplace_back().ellipse.mass_levels = 1000.0 * (1.0 + scatter_(random_));
    }
    identifier_.identify(seen, &set);
    return set;
  }

  void rewind() { frame_ = 0; }

  /// How often each light was taken for the one that blinks, in two seconds after three.
  std::vector<int> identified() {
    for (int i = 0; i < 90; ++i) next();
    std::vector<int> counts(lights_.size(), 0);
    for (int i = 0; i < 60; ++i) {
      for (const Bearing& bearing : next().candidates) {
        const bool named = bearing.light_id != kUnknownLight;
        EXPECT_EQ(bearing.probability, named ? 1.0 : 0.0);
        counts[static_cast<std::size_t>(bearing.image_radius_px)] += named ? 1 : 0;
      }
    }
    return counts;
  }

 private:
  BlinkIdentifier identifier_;
  std::vector<TestLight> lights_;
  int frame_ = 0;
  std::mt19937 random_{3};
  std::uniform_real_distribution<double> late_{0.0, 0.004};
  std::normal_distribution<double> scatter_{0.0, 0.05};
};

TEST(BlinkIdentifier, FindsTheLightAmongSteadyAndOtherOnes) {
  const std::vector<int> counts =
      Spin(blinkAtFive(), {{0.0, 0.0}, {1.0, 5.0}, {2.0, 8.0}, {3.0, 2.0}, {-2.0, 12.0}})
          .identified();
  EXPECT_GE(counts[1], 28) << "of 30 frames in which it is on";
  for (const std::size_t other : {0u, 2u, 3u, 4u}) EXPECT_EQ(counts[other], 0) << other;
}

TEST(BlinkIdentifier, AShortFlashIsFoundToo) {
  EXPECT_GE(Spin(blinkAtFive(), {{0.5, 5.0, 0.34}}).identified()[0], 18);  // of 20
}

void expectNothingNamed(Spin* spin) {
  const int frames = static_cast<int>(0.7 * blinkAtFive().window_s / kFrame_s);
  for (int i = 0; i < frames; ++i) {
    for (const Bearing& bearing : spin->next().candidates) {
      EXPECT_EQ(bearing.light_id, kUnknownLight);
    }
  }
}

TEST(BlinkIdentifier, NamesNothingBeforeItHasSeenTheLightForLong) {
  Spin spin(blinkAtFive(), {{1.0, 5.0}});
  expectNothingNamed(&spin);
}

TEST(BlinkIdentifier, TooFewFramesTellNoRate) {
  BlinkConfig fast = blinkAtFive();
  fast.rate_hz = 25.0;  // at 30 frames a second it looks like 5
  EXPECT_EQ(Spin(fast, {{1.0, 5.0}}).identified()[0], 0);
}

/// A candidate that comes and goes at random: of its variance the part at any rate is larger than p
/// with the probability exp(-p n / 2), n the frames of the window.
TEST(BlinkIdentifier, RandomFlickerIsRarelyTakenForTheLight) {
  BlinkConfig config = blinkAtFive();
  config.min_part_at_rate = 0.1;  // so low that it happens
  std::mt19937 random(5);
  std::bernoulli_distribution on(0.5);
  const double frames = config.window_s / kFrame_s;
  int looks = 0, taken = 0;
  for (int run = 0; run < 400; ++run) {
    BlinkIdentifier identifier(config);
    for (int i = 0; i < 60; ++i) {
      BearingSet set;
      set.stamp = stampFromSeconds(100.0 + kFrame_s * i);
      if (on(random)) set.candidates.emplace_back();
      std::vector<Detection> seen(set.candidates.size());
      for (Detection& light : seen) light.ellipse.mass_levels = 1.0;
      identifier.identify(seen, &set);
      if (i < 59 || set.candidates.empty()) continue;
      ++looks;
      taken += set.candidates.front().light_id != kUnknownLight ? 1 : 0;
    }
  }
  const double expected = std::exp(-0.5 * config.min_part_at_rate * frames);
  const double sigma = std::sqrt(expected * (1.0 - expected) / looks);
  EXPECT_NEAR(taken / static_cast<double>(looks), expected, 4.0 * sigma);
}

TEST(BlinkIdentifier, BeginsAnewWhenTimeJumpsBack) {
  Spin spin(blinkAtFive(), {{1.0, 5.0}});
  EXPECT_GT(spin.identified()[0], 0);
  spin.rewind();
  expectNothingNamed(&spin);
}

TEST(BlinkIdentifier, RefusesWhatCannotBe) {
  BearingSet set;
  BlinkIdentifier identifier(blinkAtFive());
  EXPECT_THROW(identifier.identify({Detection()}, &set), std::invalid_argument);
  BlinkConfig config = blinkAtFive();
  config.rate_hz = 1.0;  // one and a half periods
  EXPECT_THROW(BlinkIdentifier{config}, std::invalid_argument);
  config = blinkAtFive();
  config.light_id = kUnknownLight;
  EXPECT_THROW(BlinkIdentifier{config}, std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
