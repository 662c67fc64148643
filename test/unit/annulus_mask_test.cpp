#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/search_region.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using Pixels = std::set<std::pair<int, int>>;

Pixels pixelsOf(const std::vector<PixelStrip>& strips) {
  Pixels pixels;
  for (const PixelStrip& strip : strips) {
    for (int u = strip.begin; u < strip.end; ++u) {
      EXPECT_TRUE(pixels.insert({strip.row, u}).second) << "twice: " << strip.row << " " << u;
    }
  }
  return pixels;
}

DetectorConfig smallDetector(int handedness) {
  DetectorConfig config = test::defaultDetector();
  config.sensor.width_px = 120;
  config.sensor.height_px = 90;
  config.view = {61.3, 43.8, handedness};
  config.mask.inner_radius_px = 10.0;
  config.mask.outer_radius_px = 50.0;
  config.mask.first_row = 3;
  config.mask.last_row = 80;
  config.mask.posts = {{radiansFromDegrees(90.0), radiansFromDegrees(8.0)},
                       {radiansFromDegrees(-175.0), radiansFromDegrees(10.0)}};
  return config;
}

TEST(AnnulusMask, HoldsTheAnnulusLessPostsAndRows) {
  for (int handedness : {1, -1}) {
    const DetectorConfig config = smallDetector(handedness);
    const AnnulusMask mask(config);
    const Pixels pixels = pixelsOf(mask.strips());
    for (int v = 0; v < config.sensor.height_px; ++v) {
      for (int u = 0; u < config.sensor.width_px; ++u) {
        const double du = u - 61.3;
        const double up = 43.8 - v;
        const double radius = std::sqrt(du * du + up * up);
        const double azimuth_deg = handedness * degreesFromRadians(std::atan2(up, du));
        const bool in_post = (azimuth_deg >= 82.0 && azimuth_deg <= 98.0) || azimuth_deg >= 175.0 ||
                             azimuth_deg <= -165.0;
        const bool expected = radius >= 10.0 && radius <= 50.0 && v >= 3 && v <= 80 && !in_post;
        EXPECT_EQ(pixels.count({v, u}) == 1, expected) << "row " << v << " column " << u;
        EXPECT_EQ(mask.contains(u, v), expected);
      }
    }
  }
}

TEST(AnnulusMask, APixelBesideTheImageIsOutside) {
  const DetectorConfig config = smallDetector(1);
  const AnnulusMask mask(config);
  EXPECT_FALSE(mask.contains(-1.0, 40.0));
  EXPECT_FALSE(mask.contains(120.0, 40.0));
  EXPECT_FALSE(mask.contains(60.0, 1e12));
  EXPECT_FALSE(mask.contains(std::nan(""), 40.0));
}

TEST(AnnulusMask, ASectorIsTheMaskWithinItsAngle) {
  for (int handedness : {1, -1}) {
    const DetectorConfig config = smallDetector(handedness);
    const AnnulusMask mask(config);
    std::vector<PixelStrip> clipped;
    for (double centre_deg = -180.0; centre_deg <= 180.0; centre_deg += 15.0) {
      for (double half_width_deg : {3.0, 20.0, 89.0}) {
        mask.clipToSector({radiansFromDegrees(centre_deg), radiansFromDegrees(half_width_deg)},
                          &clipped);
        const Pixels found = pixelsOf(clipped);
        for (const auto& [v, u] : pixelsOf(mask.strips())) {
          const double azimuth = mirrorPixelFromImage(config.view, u, v).azimuth_rad;
          const double off =
              std::abs(degreesFromRadians(wrapAngle(azimuth - radiansFromDegrees(centre_deg))));
          constexpr double kOnTheBorder_deg = 1e-9;
          if (std::abs(off - half_width_deg) < kOnTheBorder_deg) continue;
          EXPECT_EQ(found.count({v, u}) == 1, off < half_width_deg)
              << "row " << v << " column " << u << " sector " << centre_deg << " +- "
              << half_width_deg;
        }
      }
    }
  }
}

TEST(AnnulusMask, ABoxIsTheMaskWithinIt) {
  const DetectorConfig config = smallDetector(1);
  const AnnulusMask mask(config);
  std::vector<PixelStrip> clipped;
  const cv::Rect boxes[] = {{30, 20, 70, 40}, {-5, -5, 505, 505}, {61, 40, 1, 10}, {0, 0, 120, 0}};
  for (const cv::Rect& box : boxes) {
    mask.clipToBox(box, &clipped);
    const Pixels found = pixelsOf(clipped);
    for (const auto& [v, u] : pixelsOf(mask.strips())) {
      EXPECT_EQ(found.count({v, u}) == 1, box.contains({u, v})) << "row " << v << " column " << u;
    }
  }
}

// 35 px from the centre, with the mask's end at 50 px.
TEST(AnnulusMask, CutsWhatReachesBeyondItsEnd) {
  const AnnulusMask mask(smallDetector(1));
  constexpr double kLong_px = 10.0;
  constexpr double kShort_px = 1.0;
  const auto ellipse = [](double stddev_u_px, double stddev_v_px) {
    const Eigen::Vector2d stddev_px(stddev_u_px, stddev_v_px);
    return PixelEllipse{{61.3 + 35.0, 43.8}, stddev_px.cwiseAbs2().asDiagonal(), 2.0};
  };
  EXPECT_FALSE(mask.cuts(ellipse(kShort_px, kShort_px)));
  EXPECT_FALSE(mask.cuts(ellipse(kShort_px, kLong_px)));
  EXPECT_TRUE(mask.cuts(ellipse(kLong_px, kShort_px)));
}

TEST(AnnulusMask, AHalfPlaneIsNoSector) {
  const DetectorConfig config = smallDetector(1);
  const AnnulusMask mask(config);
  std::vector<PixelStrip> clipped;
  EXPECT_THROW(mask.clipToSector({0.0, 0.5 * kPi}, &clipped), std::invalid_argument);
  EXPECT_THROW(mask.clipToSector({0.0, 0.0}, &clipped), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
