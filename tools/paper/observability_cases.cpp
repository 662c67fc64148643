#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "tools/paper/observability_ranks.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSpeed_mps = 0.2;
constexpr double kSeparation_m = 0.25;

using Motion = std::vector<DriveSegment>;

DriveSegment straight(double length_m) {
  return {std::copysign(kSpeed_mps, length_m), std::copysign(kSpeed_mps, length_m),
          std::abs(length_m) / kSpeed_mps};
}

/// To the left on the spot.
DriveSegment spin(double angle_rad) {
  return {-kSpeed_mps, kSpeed_mps, 0.5 * kSeparation_m * angle_rad / kSpeed_mps};
}

/// To the left on a circle; the outer wheel is the faster one.
DriveSegment arc(double radius_m, double angle_rad) {
  const double outer_m = radius_m + 0.5 * kSeparation_m;
  const double inner_m = radius_m - 0.5 * kSeparation_m;
  return {kSpeed_mps * inner_m / outer_m, kSpeed_mps, outer_m * angle_rad / kSpeed_mps};
}

/// Steering that swings like a sine, in short arcs.
Motion sinusoid() {
  constexpr int kArcs = 120;
  constexpr double kDuration_s = 60.0;
  constexpr double kSwings = 4.0;
  constexpr double kSteering = 0.5;  // of the speed, faster one wheel and slower the other
  Motion motion;
  for (int i = 0; i < kArcs; ++i) {
    const double difference = kSteering * std::sin(2.0 * kPi * kSwings * (i + 0.5) / kArcs);
    motion.push_back(
        {kSpeed_mps * (1.0 - difference), kSpeed_mps * (1.0 + difference), kDuration_s / kArcs});
  }
  return motion;
}

/// Three legs of the paper's second trajectory.
Motion dance() {
  const DriveSegment turn = spin(2.5 * kPi);
  return {straight(1.0), turn, straight(1.0), turn, straight(1.0)};
}

ObservabilityCase byMotion(const std::string& words, const Motion& motion, int rank) {
  ObservabilityCase observed;
  observed.motion = words;
  observed.segments = motion;
  observed.expected_rank = rank;
  return observed;
}

/// The light on the line along which the sensor moves when the base drives straight: beside the
/// base's own x axis by as much as the sensor is.
ObservabilityCase alongTheRay(ObservabilityCase observed) {
  constexpr double kSensorBeside_m = 0.05;
  observed.light_y_m = kSensorBeside_m;
  return observed;
}

ObservabilityCase onCircleAboutLight() {
  constexpr double kRadius_m = 1.2;
  ObservabilityCase observed =
      byMotion("one circle about the light", {arc(kRadius_m, 2.0 * kPi)}, 3);
  observed.light_x_m = 0.0;
  observed.light_y_m = kRadius_m;
  return observed;
}

ObservabilityCase inParametrisation(const std::string& words, Parametrisation parametrisation,
                                    int rank) {
  ObservabilityCase observed = byMotion(words, dance(), rank);
  observed.parametrisation = parametrisation;
  return observed;
}

ObservabilityCase withBlocks(const std::string& words, const std::vector<Unknown>& unknowns,
                             bool with_elevation, int rank) {
  ObservabilityCase observed = byMotion("dance, " + words, dance(), rank);
  observed.unknowns = unknowns;
  observed.with_elevation = with_elevation;
  return observed;
}

ObservabilityCase withSecondLight(const std::string& words, const Motion& motion, int rank) {
  ObservabilityCase observed = byMotion(words + ", two lights", motion, rank);
  observed.unknowns = {Unknown::kSecondLight};
  return observed;
}

}  // namespace

std::vector<ObservabilityCase> observabilityCases() {
  const DriveSegment turn = spin(0.5 * kPi);
  const DriveSegment round = spin(2.0 * kPi);
  const Motion spin_between = {straight(1.0), round};
  constexpr Unknown kHeight = Unknown::kLightHeight;
  return {byMotion("standing", {{0.0, 0.0, 5.0}}, 1),
          byMotion("pure rotation", {round}, 3),
          byMotion("one straight line", {straight(2.0)}, 3),
          byMotion("the line back and forth", {straight(2.0), straight(-2.0)}, 3),
          alongTheRay(byMotion("one line through light and sensor", {straight(1.0)}, 2)),
          byMotion("one circle", {arc(0.5, 2.0 * kPi)}, 3),
          onCircleAboutLight(),
          byMotion("straight, then one spin", spin_between, 5),
          byMotion("one spin, then straight", {round, straight(1.0)}, 5),
          alongTheRay(byMotion("straight along the ray, then one spin", spin_between, 4)),
          byMotion("straight, 90 deg, straight", {straight(1.0), turn, straight(1.0)}, 5),
          byMotion("two arcs of different radius", {arc(0.5, kPi), arc(1.0, kPi)}, 5),
          byMotion("sinusoidal steering", sinusoid(), 5),
          inParametrisation("dance, the paper's X", Parametrisation::kPaper, 5),
          inParametrisation("dance, the paper's X_a", Parametrisation::kPaperAugmented, 5),
          withBlocks("wheel scales", {Unknown::kWheelScales}, false, 7),
          withBlocks("wheel scales and separation",
                     {Unknown::kWheelScales, Unknown::kWheelSeparation}, false, 7),
          withBlocks("time offset", {Unknown::kTimeOffset}, false, 6),
          withBlocks("two lights", {Unknown::kSecondLight}, false, 7),
          withSecondLight("pure rotation", {round}, 5),
          withSecondLight("one straight line", {straight(2.0)}, 5),
          withSecondLight("one circle", {arc(0.5, 2.0 * kPi)}, 5),
          withBlocks("two lights, wheel scales and separation",
                     {Unknown::kSecondLight, Unknown::kWheelScales, Unknown::kWheelSeparation},
                     false, 9),
          withBlocks("tilt, light's height known", {Unknown::kTilt}, false, 5),
          withBlocks("first harmonic", {Unknown::kFirstHarmonic}, false, 7),
          withBlocks("tilt, height, first harmonic, with elevations",
                     {Unknown::kTilt, kHeight, Unknown::kFirstHarmonic}, true, 10),
          withBlocks("the same, wheel scales, time offset, with elevations",
                     {Unknown::kTilt, kHeight, Unknown::kFirstHarmonic, Unknown::kWheelScales,
                      Unknown::kTimeOffset},
                     true, 13)};
}

}  // namespace bearing_calibration::core
