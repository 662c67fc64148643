#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/vision/light_bearings.h"

namespace bearing_calibration::core {
namespace {

/// Two lights, the first where it is expected, 1.5 m away.
class Ranged : public testing::Test {
 protected:
  Ranged() {
    for (double azimuth_rad : {0.5, 1.5}) {
      Detection light;
      light.bearing.azimuth_rad = azimuth_rad;
      light.bearing.image_radius_px = 200.0;
      light.ellipse.moments_px2 << 20.0, 0.0, 0.0, 6.0;
      lights_.push_back(light);
    }
    prediction_.distance_m = 1.5;
    prediction_.distance_variance_m2 = 1e-4;
  }
  std::optional<RangedSpot> spot() const {
    BearingSet bearings{kNow, {}};
    for (const Detection& light : lights_) bearings.candidates.push_back(light.bearing);
    return rangedSpot(lights_, bearings, prediction_);
  }

  static constexpr Stamp kNow{std::chrono::seconds(7)};
  std::vector<Detection> lights_;
  BearingPrediction prediction_{kNow, 0.51, 1e-4};
};

TEST_F(Ranged, TheLightThatIsExpectedIsTheOne) {
  ASSERT_TRUE(spot());
  EXPECT_EQ(spot()->stamp, kNow);
  EXPECT_EQ(spot()->azimuth_rad, 0.5);
  EXPECT_EQ(spot()->image_radius_px, 200.0);
  EXPECT_EQ(spot()->variances_px2, Eigen::Vector2d(20.0, 6.0));
  EXPECT_EQ(spot()->distance_m, 1.5);
  EXPECT_EQ(spot()->distance_variance_m2, 1e-4);
}

TEST_F(Ranged, NoneWhereAnotherStandsBesideIt) {
  lights_[1].bearing.azimuth_rad = 0.53;
  EXPECT_FALSE(spot());
  lights_[1].bearing.probability = 0.4;
  EXPECT_TRUE(spot());
}

TEST_F(Ranged, NoneElsewhereUnlikelyOrFull) {
  const std::vector<Detection> good = lights_;
  lights_[0].bearing.azimuth_rad = 0.6;
  EXPECT_FALSE(spot());
  lights_ = good;
  lights_[0].bearing.probability = 0.4;
  EXPECT_FALSE(spot());
  lights_ = good;
  lights_[0].ellipse.saturated_fraction = 0.3;
  EXPECT_FALSE(spot());
}

TEST_F(Ranged, NoneWithoutANewDistanceThatIsKnownWell) {
  const BearingPrediction good = prediction_;
  prediction_.distance_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(spot());
  prediction_ = good;
  prediction_.distance_variance_m2 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(spot());
  prediction_.distance_variance_m2 = 0.01;
  EXPECT_FALSE(spot());
  prediction_ = good;
  prediction_.stamp += durationFromSeconds(0.3);
  EXPECT_FALSE(spot());
}

}  // namespace
}  // namespace bearing_calibration::core
