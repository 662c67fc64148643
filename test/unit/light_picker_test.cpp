// Which candidate is the light, while nothing else is known.

#include "bearing_calibration/track/light_picker.h"

#include <gtest/gtest.h>

#include <random>

namespace bearing_calibration::core {
namespace {

constexpr double kNoise_rad = 0.01;

Bearing bearingAt(double azimuth_rad) {
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad;
  bearing.azimuth_variance_rad2 = kNoise_rad * kNoise_rad;
  return bearing;
}

/// Two centimetres ahead, with a turn.
OdometryIncrement step(double turn_rad) {
  OdometryIncrement motion;
  motion.start_from_end = Pose2{{0.02, 0.0}, turn_rad};
  motion.distance_m = 0.02;
  motion.rotation_rad = std::abs(turn_rad);
  return motion;
}

/// Azimuths of two lights that pass each other after `images` / 2, the robot turning all the time.
struct Passing {
  double turn_rad = 0.05;
  double speed_rad = 0.0;  ///< of each by itself, in opposite senses
  int images = 0;
  double azimuth(int image, double sense) const {
    return sense * speed_rad * (image - images / 2) - turn_rad * image;
  }
};

/// What became of following the first of them.
struct Followed {
  int found = 0;
  int mixed_up = 0;  ///< the other one was found
  bool is_lost = false;
};
Followed follow(const Passing& passing) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, kNoise_rad);
  LightPicker picker;
  Followed followed;
  for (int image = 0; image < passing.images && !followed.is_lost; ++image) {
    picker.move(step(image == 0 ? 0.0 : passing.turn_rad));
    const std::vector<Bearing> candidates = {
        bearingAt(passing.azimuth(image, 1.0) + noise(random)),
        bearingAt(passing.azimuth(image, -1.0) + noise(random))};
    const Association choice = picker.pick(candidates, true);
    followed.is_lost = picker.isLost();
    if (choice.kind != Association::Kind::kFound) continue;
    ++followed.found;
    if (choice.candidate == 1) ++followed.mixed_up;
  }
  return followed;
}

// Two bearings of one noise make their mean.
TEST(LightPicker, ExpectsTheLightInTheMiddleOfWhatWasSeen) {
  LightPicker picker;
  picker.pick({bearingAt(0.1)}, false);
  picker.pick({bearingAt(0.13)}, false);
  EXPECT_EQ(picker.pick({bearingAt(0.11), bearingAt(0.125)}, false).candidate, 0U);
}

// What passes in a few images goes on at its speed.
TEST(LightPicker, FollowsALightThatAnotherPassesQuickly) {
  const Followed followed = follow({0.05, 0.02, 80});
  EXPECT_FALSE(followed.is_lost);
  EXPECT_EQ(followed.mixed_up, 0);
  EXPECT_GT(followed.found, 60);
}

TEST(LightPicker, GivesUpALightThatAnotherPassesSlowly) {
  const Followed followed = follow({0.05, 0.002, 400});
  EXPECT_TRUE(followed.is_lost);
  EXPECT_EQ(followed.mixed_up, 0);
  EXPECT_GT(followed.found, 100);
}

TEST(LightPicker, BeginsWhereNoOtherLightIsNear) {
  LightPicker picker;
  EXPECT_EQ(picker.pick({bearingAt(1.0), bearingAt(1.05)}, true).kind,
            Association::Kind::kAmbiguous);
  const Association choice = picker.pick({bearingAt(1.0), bearingAt(1.05), bearingAt(2.0)}, true);
  EXPECT_EQ(choice.kind, Association::Kind::kFound);
  EXPECT_EQ(choice.candidate, 2U);
}

TEST(LightPicker, BeginsWithWhatItsTrackMakesLikelier) {
  std::vector<Bearing> candidates = {bearingAt(1.0), bearingAt(2.0), bearingAt(-2.0)};
  candidates[0].probability = 0.9;  // by its image alone
  candidates[0].track_probability = 0.2;
  candidates[1].probability = 0.4;
  candidates[1].track_probability = 0.8;
  candidates[2].probability = 0.7;  // not followed
  EXPECT_EQ(LightPicker().pick(candidates, false).candidate, 1U);
  candidates[1].track_probability = 0.0;
  EXPECT_EQ(LightPicker().pick(candidates, false).candidate, 2U);
}

// Seen once, it may move by up to 1 rad/m. Whether others are seen meanwhile or nothing at all,
// what is seen afterwards is not taken for it.
TEST(LightPicker, TakesNoOtherLightForTheOneThatWasHidden) {
  for (const bool others_are_seen : {true, false}) {
    LightPicker picker;
    picker.pick({bearingAt(1.0)}, true);
    for (int image = 0; image < 4; ++image) {
      picker.move(step(0.0));
      EXPECT_NE(
          picker
              .pick(others_are_seen ? std::vector<Bearing>{bearingAt(2.5)} : std::vector<Bearing>{},
                    true)
              .kind,
          Association::Kind::kFound);
      EXPECT_FALSE(picker.isLost());
    }
    for (int image = 0; image < 10; ++image) picker.move(step(0.0));
    EXPECT_NE(picker.pick({bearingAt(1.5)}, true).kind, Association::Kind::kFound);
    EXPECT_TRUE(picker.isLost());
  }
}

// An only light that is somewhere else is seen there: the wheels have slipped, or it was not the
// light before.
TEST(LightPicker, TakesTheOnlyLightWhereverItIs) {
  LightPicker picker;
  picker.pick({bearingAt(1.0)}, false);
  for (int image = 0; image < 100; ++image) {
    EXPECT_EQ(picker.pick({bearingAt(image % 2 == 0 ? -1.0 : 1.0)}, false).kind,
              Association::Kind::kFound);
    EXPECT_FALSE(picker.isLost());
  }
}

}  // namespace
}  // namespace bearing_calibration::core
