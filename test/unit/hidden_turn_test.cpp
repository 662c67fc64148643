// A slip of the wheels turns all lights by the same angle.

#include <gtest/gtest.h>

#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {
namespace {

constexpr double kNoise_rad = 0.01;

std::vector<AzimuthPrediction> expectedAt(const std::vector<double>& azimuths_rad) {
  std::vector<AzimuthPrediction> expected;
  for (const double azimuth_rad : azimuths_rad) {
    expected.push_back({azimuth_rad, kNoise_rad * kNoise_rad});
  }
  return expected;
}

/// Where lights are seen after the base has turned by more than is known; not in their order.
std::vector<Bearing> seenAt(const std::vector<double>& azimuths_rad, double turn_rad) {
  std::vector<Bearing> seen;
  for (auto azimuth = azimuths_rad.rbegin(); azimuth != azimuths_rad.rend(); ++azimuth) {
    Bearing bearing;
    bearing.azimuth_rad = wrapAngle(*azimuth - turn_rad);
    bearing.azimuth_variance_rad2 = kNoise_rad * kNoise_rad;
    seen.push_back(bearing);
  }
  return seen;
}

const std::vector<double> kTwo = {3.0, 0.5};
const std::vector<double> kFour = {3.0, 0.5, -1.9, 1.4};

TEST(HiddenTurn, IsThatOfAllLights) {
  for (const double turn_rad : {-0.4, 0.2}) {
    for (const std::vector<double>& lights : {kTwo, kFour}) {
      const auto found = hiddenTurn(expectedAt(lights), seenAt(lights, turn_rad));
      ASSERT_TRUE(found.has_value());
      EXPECT_NEAR(*found, turn_rad, 1e-9);
    }
  }
}

// The base has slid, too: each light is off by some more, and the turn is their mean.
TEST(HiddenTurn, LeavesEachLightSomethingOfItsOwn) {
  std::vector<Bearing> seen = seenAt(kFour, 0.2);
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i].azimuth_rad += i % 2 == 0 ? 0.02 : -0.02;
  const auto found = hiddenTurn(expectedAt(kFour), seen);
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(*found, 0.2, 1e-9);
}

TEST(HiddenTurn, MayHideOneOfFourButNoneOfTwo) {
  std::vector<Bearing> seen = seenAt(kFour, 0.2);
  seen.pop_back();
  EXPECT_TRUE(hiddenTurn(expectedAt(kFour), seen).has_value());
  seen = seenAt(kTwo, 0.2);
  seen.pop_back();
  EXPECT_FALSE(hiddenTurn(expectedAt(kTwo), seen).has_value());
}

TEST(HiddenTurn, IsNoneWhereLightsAreAsExpected) {
  EXPECT_FALSE(hiddenTurn(expectedAt(kFour), seenAt(kFour, 0.02)).has_value());
  EXPECT_FALSE(hiddenTurn({}, seenAt(kFour, 0.2)).has_value());
  EXPECT_FALSE(hiddenTurn(expectedAt(kFour), {}).has_value());
}

// After a turn by 0.2 rad the fourth light stands where the second was expected.
TEST(HiddenTurn, IsFoundWhereOneLightStandsInThePlaceOfAnother) {
  const std::vector<double> lights = {3.0, 0.5, -1.9, 0.7};
  const auto found = hiddenTurn(expectedAt(lights), seenAt(lights, 0.2));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(*found, 0.2, 1e-9);
}

// One that moves is off alone.
TEST(HiddenTurn, IsNoneWhereOneLightMoves) {
  std::vector<Bearing> seen = seenAt(kFour, 0.0);
  seen.front().azimuth_rad += 0.3;
  EXPECT_FALSE(hiddenTurn(expectedAt(kFour), seen).has_value());
}

// Candidates 0.4 rad apart fit a turn by 0.2 and one by -0.2.
TEST(HiddenTurn, IsNoneWhereTwoTurnsExplainIt) {
  std::vector<Bearing> seen = seenAt(kTwo, 0.2);
  for (const Bearing& other : seenAt(kTwo, -0.2)) seen.push_back(other);
  EXPECT_FALSE(hiddenTurn(expectedAt(kTwo), seen).has_value());
}

}  // namespace
}  // namespace bearing_calibration::core
