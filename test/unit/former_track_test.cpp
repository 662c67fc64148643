#include <gtest/gtest.h>

#include "bearing_calibration/track/mount_tracker.h"

namespace bearing_calibration::core {
namespace {

constexpr FusionConfig kFusion{9.0, 1.0};
constexpr double kThere_rad = 0.0;
constexpr double kElsewhere_rad = 1.0;

/// A light straight ahead, known to a centimetre, of a robot that stands.
FormerTrack trackAhead() {
  CartesianEstimate estimate;
  estimate.mean << 2.0, 0.0, 0.0, 0.0, 0.0;
  estimate.covariance = 1e-4 * Matrix5::Identity();
  return FormerTrack(LiveFilter(StateEstimate::of(estimate)));
}

std::vector<Bearing> lightAt(double azimuth_rad) {
  Bearing bearing;
  bearing.azimuth_rad = azimuth_rad;
  bearing.azimuth_variance_rad2 = 1e-4;
  return {bearing};
}

/// Images that show a light there, of which the present place knows nothing.
void show(double azimuth_rad, int images, FormerTrack* track) {
  for (int i = 0; i < images; ++i) track->fuse(lightAt(azimuth_rad), {}, kFusion, Association());
}

// One light at the old place may be any light; five images in a row are no chance.
TEST(FormerTrack, ALightIsBackWhenNearlyAllImagesShowIt) {
  FormerTrack track = trackAhead();
  EXPECT_FALSE(track.isBack());
  show(kThere_rad, 1, &track);
  EXPECT_FALSE(track.isBack());
  show(kThere_rad, 4, &track);
  EXPECT_TRUE(track.isBack());
  show(kElsewhere_rad, 1, &track);
  EXPECT_FALSE(track.isBack()) << "the last image does not show it";
  show(kThere_rad, 1, &track);
  EXPECT_TRUE(track.isBack()) << "all but one do";
}

TEST(FormerTrack, ALightThatComesAndGoesIsNotBack) {
  FormerTrack track = trackAhead();
  for (int i = 0; i < 10; ++i) {
    show(kElsewhere_rad, 1, &track);
    show(kThere_rad, 1, &track);
    EXPECT_FALSE(track.isBack()) << i;
  }
}

TEST(FormerTrack, WhatIsSeenAtThePresentPlaceTooTellsNothing) {
  FormerTrack track = trackAhead();
  Association present;  // it expects the same light, and as well
  for (int i = 0; i < 10; ++i) {
    present = associate(track.filter().predictAzimuth(), lightAt(kThere_rad), kFusion.gate);
    ASSERT_EQ(present.kind, Association::Kind::kFound);
    track.fuse(lightAt(kThere_rad), {}, kFusion, present);
    EXPECT_FALSE(track.isBack()) << i;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
