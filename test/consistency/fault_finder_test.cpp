// Each single fault of a robot is told by its name, and a sound robot is told none.
#include "bearing_calibration/calibration/fault_finder.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/sight_change.h"
#include "tools/simulated_case.h"

namespace bearing_calibration {
namespace {

constexpr int kRuns = 3;
constexpr double kDuration_s = 60.0;

std::vector<Sight> sightsOf(const SimulatedCase& simulated) { return simulate(simulated).sights; }

SimulatedCase soundCase(std::uint64_t seed) {
  SimulatedCase simulated = paperCase(seed);
  simulated.duration_s = kDuration_s;
  return simulated;
}

Diagnosis diagnose(const SimulatedCase& simulated, const std::vector<Sight>& sights) {
  return findFault(sights, simulated.robot.encoders.drive.wheel_separation_m, InitializerConfig{});
}

/// What the record would be with wheels wired or believed otherwise.
std::vector<Sight> miswired(const SimulatedCase& simulated, const Eigen::Matrix2d& wheels) {
  const double b = simulated.robot.encoders.drive.wheel_separation_m;
  return withOtherWheels(sightsOf(simulated), wheels, b, b);
}

TEST(FindFault, TellsASoundRobotNothing) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = soundCase(seed);
    EXPECT_EQ(describe(diagnose(simulated, sightsOf(simulated))), "") << "seed " << seed;
  }
}

TEST(FindFault, TellsSwappedWheels) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = soundCase(seed);
    const Eigen::Matrix2d swap = (Eigen::Matrix2d() << 0.0, 1.0, 1.0, 0.0).finished();
    EXPECT_EQ(diagnose(simulated, miswired(simulated, swap)).fault, Fault::kMirrored) << seed;
  }
}

// The same data up to the mount: a mirrored bearing is a mirrored motion, in another mirror.
TEST(FindFault, TellsAMirroredBearingByTheSameName) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = soundCase(seed);
    std::vector<Sight> sights = sightsOf(simulated);
    for (Sight& sight : sights) sight.azimuth_rad = -sight.azimuth_rad;
    EXPECT_EQ(diagnose(simulated, sights).fault, Fault::kMirrored) << seed;
  }
}

// Swapped and reversed, both wheels: the base's x axis points backwards, and everything fits.
TEST(FindFault, CannotTellABaseThatIsTurnedRound) {
  const SimulatedCase simulated = soundCase(1);
  const Eigen::Matrix2d turned = (Eigen::Matrix2d() << 0.0, -1.0, -1.0, 0.0).finished();
  EXPECT_EQ(diagnose(simulated, miswired(simulated, turned)).fault, Fault::kNone);
}

TEST(FindFault, TellsAReversedWheel) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const SimulatedCase simulated = soundCase(seed);
    const Eigen::Matrix2d left = Eigen::Vector2d(-1.0, 1.0).asDiagonal();
    const Eigen::Matrix2d right = Eigen::Vector2d(1.0, -1.0).asDiagonal();
    EXPECT_EQ(diagnose(simulated, miswired(simulated, left)).fault, Fault::kLeftReversed) << seed;
    EXPECT_EQ(diagnose(simulated, miswired(simulated, right)).fault, Fault::kRightReversed) << seed;
  }
}

TEST(FindFault, TellsALateCameraAndByHowMuch) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = soundCase(seed);
    simulated.robot.stamp_latency_s = 0.1;
    const Diagnosis diagnosis = diagnose(simulated, sightsOf(simulated));
    EXPECT_EQ(diagnosis.fault, Fault::kLate) << seed;
    EXPECT_NEAR(diagnosis.size, 0.1, 0.05) << seed;
  }
}

TEST(FindFault, TellsAWheelThatIsTooLarge) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = soundCase(seed);
    simulated.robot.encoders.right_radius_factor = 1.1;  // true over believed
    const Diagnosis diagnosis = diagnose(simulated, sightsOf(simulated));
    EXPECT_EQ(diagnosis.fault, Fault::kRightRadius) << seed;
    EXPECT_NEAR(diagnosis.size, 1.1, 0.03) << seed;
  }
}

TEST(FindFault, TellsAWrongSeparation) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = soundCase(seed);
    simulated.robot.separation_factor = 1.1;  // true over believed
    const Diagnosis diagnosis = diagnose(simulated, sightsOf(simulated));
    EXPECT_EQ(diagnosis.fault, Fault::kSeparation) << seed;
    EXPECT_NEAR(diagnosis.size, 1.1, 0.03) << seed;
  }
}

TEST(FindFault, TellsALightThatMoved) {
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    SimulatedCase simulated = soundCase(seed);
    std::vector<Sight> sights = sightsOf(simulated);
    simulated.lights[0].position_m += Eigen::Vector2d(0.6, -0.8);
    const std::vector<Sight> moved = sightsOf(simulated);
    for (std::size_t i = sights.size() / 2; i < sights.size(); ++i) sights[i] = moved[i];
    EXPECT_EQ(diagnose(simulated, sights).fault, Fault::kLightMoved) << seed;
  }
}

}  // namespace
}  // namespace bearing_calibration
