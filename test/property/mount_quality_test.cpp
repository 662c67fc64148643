#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/solve/observability.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {
namespace {

/// A mount at (x, y, yaw) with this covariance.
StateEstimate mountOf(const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance) {
  return lastingPart(MountEstimate{mean, covariance});
}

Eigen::Matrix3d diagonal(double x, double y, double yaw) {
  return Eigen::Vector3d(x * x, y * y, yaw * yaw).asDiagonal();
}

TEST(MountQuality, ALightAheadIsOffByThePositionAndTheYawOnItsLever) {
  const auto aheadOf = [](const Eigen::Vector3d& mean, const Eigen::Matrix3d& covariance) {
    return qualityOf(mountOf(mean, covariance)).light_ahead_stddev_m;
  };
  const Eigen::Matrix3d covariance = diagonal(0.001, 0.004, 0.001);
  EXPECT_NEAR(aheadOf({0.0, 0.0, 1.0}, covariance), 0.005, 1e-12) << "y and 3 m of lever";
  EXPECT_NEAR(aheadOf({3.0, 0.0, 1.0}, covariance), 0.004, 1e-12) << "at the light: no lever";
  EXPECT_NEAR(aheadOf({3.0, 3.0, 1.0}, diagonal(0.004, 0.001, 0.001)), 0.005, 1e-12)
      << "the lever is to the side";
  Eigen::Matrix3d together = diagonal(0.0, 0.003, 0.001);
  together(1, 2) = together(2, 1) = -0.003 * 0.001;  // a yaw that y makes up for at 3 m
  EXPECT_NEAR(aheadOf({0.0, 0.0, 1.0}, together), 0.0, 1e-9);
}

TEST(MountQuality, TheWorstDirectionIsThatOfTheEllipse) {
  for (int degrees = -85; degrees <= 90; degrees += 5) {
    const double angle = radiansFromDegrees(degrees);
    Eigen::Matrix3d covariance = diagonal(0.004, 0.001, 0.001);
    const Eigen::Matrix2d R = rotation2(angle);
    covariance.topLeftCorner<2, 2>() =
        (R * covariance.topLeftCorner<2, 2>() * R.transpose()).eval();
    const MountQuality quality = qualityOf(mountOf({0.1, 0.1, 0.0}, covariance));
    EXPECT_NEAR(quality.worst_stddev_m, 0.004, 1e-12);
    EXPECT_NEAR(std::remainder(quality.worst_direction_rad - angle, kPi), 0.0, 1e-6);
    EXPECT_LE(std::abs(quality.worst_direction_rad), 0.5 * kPi);
  }
}

// Lengths that all stretch with the wheel separation are no pair that a motion would part.
TEST(MountQuality, TheUnitOfAllLengthsIsNoCorrelation) {
  constexpr double kScale = 0.01;
  StateEstimate robot = mountOf({0.3, 0.0, 0.0}, diagonal(0.001, 0.001, 0.001));
  EXPECT_FALSE(qualityOf(robot).most_correlated);
  constexpr int kScales = kMountSize + placeOf<WheelScales>();
  StateVector stretch = StateVector::Zero(robot.layout.size());
  stretch(0) = 0.3;
  stretch.segment<3>(kScales).setOnes();  // and the separation
  stretch *= kScale;
  robot.covariance += stretch * stretch.transpose();
  EXPECT_FALSE(qualityOf(robot).most_correlated);
  robot.covariance(kScales, kScales) += 1e-6;
  robot.covariance(0, 2) = robot.covariance(2, 0) = -0.95e-6;
  const auto pair = qualityOf(robot).most_correlated;
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->first, 0);
  EXPECT_EQ(pair->second, 2);
  EXPECT_NEAR(pair->correlation, -0.95, 1e-9);
}

TEST(MountQuality, OnlyWhatMayBeTrustedIsPraised) {
  CalibrationResult result;
  EXPECT_TRUE(qualityInWords(result).empty());
  result.state = CalibrationState::kConverged;
  EXPECT_TRUE(qualityInWords(result).empty());
  result.estimate = mountOf({0.0, 0.0, 1.0}, diagonal(0.001, 0.004, 0.001));
  const std::vector<std::string> words = qualityInWords(result);
  ASSERT_EQ(words.size(), 3U);
  EXPECT_EQ(words[0], "a light 3 m ahead is placed within 5.0 mm (68 %) along any axis");
  EXPECT_EQ(words[1],
            "the position is known least along 90 deg (0: forward, 90: left), to 4.0 mm (68 %)");
  EXPECT_EQ(words[2],
            "no other mount was found: none of 0 fits from yaws all around and 0 with a slip "
            "elsewhere");
  result.rival.offer(12.345, {0.1, -0.2, 0.5 * kPi});
  result.rival.minima = 8;
  EXPECT_EQ(qualityInWords(result)[2],
            "the next best mount, (0.100 m, -0.200 m, 90.0 deg), is behind by 12.3 of "
            "log-likelihood (open below 7): the best other one of 8 fits from yaws all around and "
            "0 with a slip elsewhere");
  result.rival.offer(12.3, {-80.0, 4e6, 0.0});
  EXPECT_EQ(qualityInWords(result)[2].find("the next best mount, (beyond 100 m, 0.0 deg), is"), 0U);
  result.state = CalibrationState::kInconsistent;
  EXPECT_TRUE(qualityInWords(result).empty());
}

// What parts two estimates is held against the bound: drives after which a pair is correlated, and
// the same drives with the motion that is named.

constexpr double kSeparation_m = 0.25;
constexpr double kSpeed_mps = 0.2;
using Segments = std::vector<DriveSegment>;

DriveSegment straight(double length_m) {
  const double speed = std::copysign(kSpeed_mps, length_m);
  return {speed, speed, std::abs(length_m) / kSpeed_mps};
}

DriveSegment turn(double angle_rad) {
  const double speed = std::copysign(kSpeed_mps, angle_rad);
  return {-speed, speed, std::abs(angle_rad) * 0.5 * kSeparation_m / kSpeed_mps};
}

Segments segmentsOf(PartingMotion motion, const Eigen::Vector2d& light_in_base) {
  const double d = light_in_base.norm();
  const DriveSegment to_light = turn(std::atan2(light_in_base.y(), light_in_base.x()));
  const DriveSegment left = turn(2.0 * kPi);
  const DriveSegment right = turn(-2.0 * kPi);
  switch (motion) {
    case PartingMotion::kTurns:
      return {left, right};
    case PartingMotion::kNearer:
      return {to_light, straight(0.5 * d), left, right};
    case PartingMotion::kDistances:
      return {to_light, straight(0.35 * d), left, straight(0.35 * d),
              left,     straight(-1.7 * d), left};
    case PartingMotion::kNone:
      break;
  }
  constexpr double kStands_s = 10.0;
  return {{0.0, 0.0, kStands_s}};
}

/// A drive for a while, then a motion.
Trajectory driveThenMotion(const SimulatedCase& simulated, const Segments& segments) {
  return
      [drive = makeTrajectory(simulated.trajectory, kSeparation_m),
       motion = segmentTrajectory(segments), left_s = simulated.duration_s](double step_s) mutable {
        left_s -= step_s;
        return left_s > 0.0 ? drive(step_s) : motion(step_s);
      };
}

StateEstimate boundOf(const SimulatedCase& simulated, const ObservationRun& run) {
  std::vector<Eigen::Vector2d> lights;
  for (const Vector5& truth : run.truth) lights.push_back(truth.head<2>());
  return cramerRaoBound(run.observations, lights, run.truth.back().tail<3>(), ErrorVector::Zero(),
                        simulated.looked_for);
}

double sizeOf(const MountQuality::Pair& pair, const StateEstimate& bound) {
  const StateMatrix& P = bound.covariance;
  const auto& [i, j, correlation] = pair;
  return std::abs(P(i, j)) / std::sqrt(P(i, i) * P(j, j));
}

/// The most correlated pair of a drive, and its correlation after a motion more.
struct CorrelatedDrive {
  SimulatedCase simulated;
  MountQuality::Pair pair;
  Eigen::Vector2d light_in_base;  ///< at its end

  double sizeAfter(PartingMotion motion) const {
    const Segments segments = segmentsOf(motion, light_in_base);
    SimulatedCase longer = simulated;
    for (const DriveSegment& segment : segments) longer.duration_s += segment.duration_s;
    const ObservationRun run = simulateAlong(longer, driveThenMotion(simulated, segments));
    return sizeOf(pair, boundOf(longer, run));
  }
};

/// Of short drives of any robot that tell the mount to 3 cm.
std::vector<CorrelatedDrive> correlatedDrives(const ErrorPriors& looked_for) {
  using Kind = TrajectoryConfig::Kind;
  constexpr int kCases = 60;
  constexpr double kKnownTo_m = 0.03;
  const RandomCaseRange range{0.5, 0.3, 4.0};
  std::vector<CorrelatedDrive> drives;
  for (const Kind kind : {Kind::kDance, Kind::kTurns, Kind::kSinusoid}) {
    for (const double duration_s : {15.0, 30.0}) {
      for (std::uint64_t seed = 1; seed <= kCases; ++seed) {
        SimulatedCase simulated = randomCase(seed, kind, range);
        simulated.looked_for = looked_for;
        simulated.duration_s = duration_s;
        const ObservationRun run = simulate(simulated);
        const MountQuality quality = qualityOf(boundOf(simulated, run));
        if (!quality.most_correlated || quality.worst_stddev_m > kKnownTo_m) continue;
        drives.push_back({simulated, *quality.most_correlated, run.truth.back().head<2>()});
      }
    }
  }
  return drives;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.at(values.size() / 2);
}

/// Sizes of correlations before the motion that is named, after it, and after the robot stood
/// still.
struct Sizes {
  std::vector<double> before;
  std::vector<double> after;
  std::vector<double> after_standing;
};

/// What is left of a variance once the other estimate is known.
double shareOfItsOwn(double correlation) { return 1.0 - correlation * correlation; }

/// "x or y, wheel_scales" and so on.
std::string kindOf(const MountQuality::Pair& pair) {
  if (pair.second < 3) return "two of x, y, yaw";
  const auto block = std::find_if(
      errorBlocks().begin(), errorBlocks().end(),
      [&](const ErrorBlockInfo& each) { return pair.second - 3 < each.begin + each.size; });
  return (pair.first < 2 ? "x or y, " : "yaw, ") + block->name;
}

// The separation is known here: a correlation is said of it as it is.
TEST(MountQuality, TheNamedMotionPartsThePair) {
  ErrorPriors plain = usualErrors();
  plain.setBlock(WheelSeparation::kName, 0.0);
  ErrorPriors with_mirror = plain;
  with_mirror.setBlock(MirrorHarmonic::kName, 0.03);
  std::map<std::string, Sizes> sizes;
  for (const ErrorPriors& looked_for : {plain, with_mirror}) {
    for (const CorrelatedDrive& drive : correlatedDrives(looked_for)) {
      Sizes& of_pair = sizes[kindOf(drive.pair)];
      of_pair.before.push_back(std::abs(drive.pair.correlation));
      of_pair.after.push_back(drive.sizeAfter(motionThatParts(drive.pair)));
      of_pair.after_standing.push_back(drive.sizeAfter(PartingMotion::kNone));
    }
  }
  int kinds = 0;
  for (const auto& [kind, of_pair] : sizes) {
    std::printf("%-30s %3zu drives, median correlation %.2f, then %.2f, standing %.2f\n",
                kind.c_str(), of_pair.before.size(), median(of_pair.before), median(of_pair.after),
                median(of_pair.after_standing));
    constexpr std::size_t kEnough = 5;
    if (of_pair.before.size() < kEnough) continue;
    ++kinds;
    const double twice = 2.0 * shareOfItsOwn(median(of_pair.before));
    EXPECT_GT(shareOfItsOwn(median(of_pair.after)), twice);
    EXPECT_LT(shareOfItsOwn(median(of_pair.after_standing)), twice);
  }
  EXPECT_EQ(kinds, 4);
}

}  // namespace
}  // namespace bearing_calibration::core
