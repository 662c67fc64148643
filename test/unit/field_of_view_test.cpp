#include "bearing_calibration/optics/field_of_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace bearing_calibration::core {
namespace {

TEST(FieldOfView, OfNoWidthOrAWholeTurnIsAllAround) {
  for (const double width_rad : {0.0, 2.0 * kPi}) {
    const FieldOfView view{1.0, width_rad};
    EXPECT_FALSE(view.isLimited());
    EXPECT_TRUE(view.isPossible());
    EXPECT_EQ(view.chanceOf(-2.0, 0.1), 1.0);
  }
}

TEST(FieldOfView, EndsAtItsBordersAcrossTheTurn) {
  const FieldOfView behind{3.0, 1.0};  // from 2.5 to 3.5 - 2 pi
  EXPECT_TRUE(behind.isLimited());
  EXPECT_EQ(behind.chanceOf(2.51, 0.0), 1.0);
  EXPECT_EQ(behind.chanceOf(2.49, 0.0), 0.0);
  EXPECT_EQ(behind.chanceOf(3.49 - 2.0 * kPi, 0.0), 1.0);
  EXPECT_EQ(behind.chanceOf(3.51 - 2.0 * kPi, 0.0), 0.0);
  EXPECT_NEAR(behind.chanceOf(2.5, 0.01), 0.5, 1e-12);  // at a border
}

/// Against the share of drawn azimuths; of one that nobody knows it is the field's part of a turn.
TEST(FieldOfView, ChanceIsTheShareOfAzimuthsInIt) {
  constexpr int kDraws = 100000;
  constexpr double kSigmas = 4.5;
  std::mt19937 random(1);
  for (const FieldOfView view : {FieldOfView{0.4, 1.0}, FieldOfView{-3.0, 5.5}}) {
    for (const double azimuth_rad : {0.3, 1.1, 2.9, -1.5}) {
      for (const double stddev_rad : {0.05, 0.5, 2.0}) {
        std::normal_distribution<double> azimuth(azimuth_rad, stddev_rad);
        int inside = 0;
        for (int i = 0; i < kDraws; ++i) {
          const double off_rad = std::remainder(azimuth(random) - view.centre_rad, 2.0 * kPi);
          inside += std::abs(off_rad) < 0.5 * view.width_rad ? 1 : 0;
        }
        const double chance = view.chanceOf(azimuth_rad, stddev_rad);
        EXPECT_NEAR(chance, 1.0 * inside / kDraws,
                    kSigmas * std::sqrt(chance * (1.0 - chance) / kDraws) + 1.0 / kDraws)
            << view.width_rad << ", " << azimuth_rad << ", " << stddev_rad;
      }
    }
  }
}

TEST(FieldOfView, IsAPartOfATurn) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE((FieldOfView{-kPi, 1.0}.isPossible()));
  for (const FieldOfView view :
       {FieldOfView{0.0, 60.0}, FieldOfView{0.0, -1.0}, FieldOfView{0.0, kNaN},
        FieldOfView{kNaN, 1.0}, FieldOfView{180.0, 1.0}}) {
    EXPECT_FALSE(view.isPossible()) << view.centre_rad << ", " << view.width_rad;
  }
}

}  // namespace
}  // namespace bearing_calibration::core
