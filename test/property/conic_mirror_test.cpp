#include "bearing_calibration/optics/conic_mirror.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "support/cone_ray_trace.h"
#include "support/default_rig.h"

namespace bearing_calibration::core {
namespace {

using test::defaultMirror;
using test::kDefaultLightHeight_m;
using test::traceToImage;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(ConicMirror, PixelToMirrorPixelAndBackIsTheIdentity) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> column(0.0, 640.0);
  std::uniform_real_distribution<double> row(0.0, 480.0);
  for (int handedness : {1, -1}) {
    const MirrorView view{321.7, 236.2, handedness};
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector2d image(column(random), row(random));
      const Eigen::Vector2d back =
          imageFromMirrorPixel(view, mirrorPixelFromImage(view, image.x(), image.y()));
      EXPECT_LT((back - image).norm(), 1e-9) << image.transpose();
    }
  }
}

TEST(ConicMirror, HandednessTurnsTheAzimuthAround) {
  constexpr double kUpOnScreen = -10.0;
  EXPECT_NEAR(mirrorPixelFromImage({0.0, 0.0, 1}, 0.0, kUpOnScreen).azimuth_rad, 0.5 * kPi, 1e-12);
  EXPECT_NEAR(mirrorPixelFromImage({0.0, 0.0, -1}, 0.0, kUpOnScreen).azimuth_rad, -0.5 * kPi,
              1e-12);
  EXPECT_NEAR(mirrorPixelFromImage({0.0, 0.0, -1}, 10.0, 0.0).azimuth_rad, 0.0, 1e-12);
}

/// The ray that leaves the mirror where a pixel looks at it, in the sensor frame.
struct MirrorRay {
  MirrorRay(const ConicMirror& mirror, const MirrorPixel& pixel) {
    const double theta = std::atan(pixel.image_radius_px / imageDistancePx(mirror));
    const double cot_tau = 1.0 / std::tan(mirror.half_angle_rad);
    const double hit_radius_m = mirror.lens_to_apex_m / (1.0 / std::tan(theta) - cot_tau);
    const double exit = 2.0 * mirror.half_angle_rad - theta;
    const Eigen::Vector3d outward(std::cos(pixel.azimuth_rad), std::sin(pixel.azimuth_rad), 0.0);
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    origin_m = hit_radius_m * (outward + cot_tau * up);
    direction = std::sin(exit) * outward + std::cos(exit) * up;
  }
  Eigen::Vector3d origin_m;
  Eigen::Vector3d direction;
};

TEST(ConicMirror, EveryPointOfAPixelsRayProjectsToThatPixel) {
  const ConicMirror mirror = defaultMirror();
  std::mt19937 random(2);
  std::uniform_real_distribution<double> radius(5.0, rimRadiusPx(mirror));
  std::uniform_real_distribution<double> azimuth(-kPi, kPi);
  std::uniform_real_distribution<double> range(0.05, 10.0);
  for (int i = 0; i < 200; ++i) {
    const MirrorPixel pixel{radius(random), azimuth(random)};
    const MirrorRay ray(mirror, pixel);
    const Eigen::Vector3d point = ray.origin_m + range(random) * ray.direction;
    const auto radius_px = radiusFromLight(mirror, {point.head<2>().norm(), point.z()});
    ASSERT_TRUE(radius_px.has_value());
    EXPECT_NEAR(*radius_px, pixel.image_radius_px, 1e-9);
  }
}

TEST(ConicMirror, RadiusAndElevationAreInverse) {
  const ConicMirror mirror = defaultMirror();
  for (double radius = 0.0; radius < 260.0; radius += 7.3) {
    const double elevation = elevationFromRadius(mirror, radius);
    EXPECT_NEAR(radiusFromElevation(mirror, elevation), radius, 1e-9);
    constexpr double kStep = 1e-4;
    const double slope = (elevationFromRadius(mirror, radius + kStep) -
                          elevationFromRadius(mirror, radius - kStep)) /
                         (2.0 * kStep);
    EXPECT_NEAR(elevationSlope(mirror, radius), slope, 1e-9);
  }
}

// Lights at the apex' height approach the horizon radius from inside as they go away.
TEST(ConicMirror, ALightBelowTheApexLiesInsideTheHorizon) {
  const ConicMirror mirror = defaultMirror();
  EXPECT_NEAR(elevationFromRadius(mirror, horizonRadiusPx(mirror)), 0.0, 1e-12);
  for (double distance : {0.3, 1.0, 5.0, 1000.0}) {
    EXPECT_LT(*radiusFromLight(mirror, {distance, 0.0}), horizonRadiusPx(mirror));
  }
  EXPECT_NEAR(*radiusFromLight(mirror, {1e7, 0.0}), horizonRadiusPx(mirror), 1e-4);
}

TEST(ConicMirror, TheRimIsWhereTheBaseRadiusIsSeen) {
  const ConicMirror mirror = defaultMirror();
  const MirrorRay ray(mirror, {rimRadiusPx(mirror), 0.4});
  EXPECT_NEAR(ray.origin_m.head<2>().norm(), mirror.base_radius_m, 1e-12);
}

TEST(ConicMirror, TheChiefRayAgreesWithTheRayTrace) {
  const ConicMirror mirror = defaultMirror();
  for (double distance : {0.3, 1.0, 5.0}) {
    for (double height : {-0.05, -0.03, 0.01}) {
      const Eigen::Vector2d traced =
          traceToImage(mirror, {}, {distance, 0.0, height}, Eigen::Vector2d::Zero());
      EXPECT_NEAR(traced.x(), *radiusFromLight(mirror, {distance, height}), 1e-6);
      EXPECT_NEAR(traced.y(), 0.0, 1e-6);
    }
  }
}

TEST(ConicMirror, ALightOutsideTheMirrorsViewHasNoPixel) {
  const double metres_below = -1.0;
  const double metres_above = 1.0;
  EXPECT_FALSE(radiusFromLight(defaultMirror(), {1.0, metres_below}));
  EXPECT_FALSE(radiusFromLight(defaultMirror(), {1.0, metres_above}));
}

// The widths are measured between rays through the two ends of the aperture's diameters.
TEST(ConicMirror, TheBlurAgreesWithTheRayTraceToAHundredthOfAPixel) {
  for (double focus : {0.06, 0.12, 1.0, kInfinity}) {
    ConicMirror mirror = defaultMirror();
    mirror.focus_distance_m = focus;
    const double half = 0.5 * mirror.aperture_m;
    for (double distance : {0.3, 0.5, 1.0, 2.0, 5.0}) {
      const Eigen::Vector3d light(distance, 0.0, kDefaultLightHeight_m);
      const double radius = *radiusFromLight(mirror, {distance, kDefaultLightHeight_m});
      const SpotBlur blur = expectedBlur(mirror, radius, distance);
      const double radial = traceToImage(mirror, {}, light, {half, 0.0}).x() -
                            traceToImage(mirror, {}, light, {-half, 0.0}).x();
      const double tangential = traceToImage(mirror, {}, light, {0.0, half}).y() -
                                traceToImage(mirror, {}, light, {0.0, -half}).y();
      EXPECT_NEAR(blur.radial_diameter_px, std::abs(radial), 0.01) << focus << " m, " << distance;
      EXPECT_NEAR(blur.tangential_diameter_px, std::abs(tangential), 0.01)
          << focus << " m, " << distance;
    }
  }
}

TEST(ConicMirror, ARayThatMissesTheMirrorShowsNothing) {
  const ConicMirror mirror = defaultMirror();
  for (const double off_rad : {-0.01, 0.01}) {  // the cone's surface, which has no end
    const double radius_px = imageDistancePx(mirror) * std::tan(mirror.half_angle_rad + off_rad);
    EXPECT_EQ(showsOutside(mirror, radius_px, 100.0), off_rad < 0.0) << off_rad;
  }
}

TEST(ConicMirror, ALightInsideTheMirrorBreaksTheContract) {
  EXPECT_THROW(expectedBlur(defaultMirror(), 200.0, 0.001), std::invalid_argument);
  EXPECT_FALSE(showsOutside(defaultMirror(), 200.0, 0.001));
  EXPECT_TRUE(showsOutside(defaultMirror(), 200.0, 1.0));
}

/// Error of the azimuth [rad] that a ray trace finds for a light at `azimuth_rad`.
double tracedError(const ConicMirror& mirror, const test::ConeMisalignment& misalignment,
                   const LightPlace& light, double azimuth_rad) {
  const Eigen::Vector3d place(light.distance_m * std::cos(azimuth_rad),
                              light.distance_m * std::sin(azimuth_rad), light.height_m);
  const Eigen::Vector2d image = traceToImage(mirror, misalignment, place, Eigen::Vector2d::Zero());
  return wrapAngle(std::atan2(image.y(), image.x()) - azimuth_rad);
}

/// Amplitude of error = amplitude * (w_t of a unit vector), from small misalignments of either
/// sign.
double tracedCoefficient(const ConicMirror& mirror, const LightPlace& light, double azimuth_rad,
                         Eigen::Vector2d test::ConeMisalignment::*which, double size) {
  const Eigen::Vector2d tangent(-std::sin(azimuth_rad), std::cos(azimuth_rad));
  test::ConeMisalignment plus;
  test::ConeMisalignment minus;
  plus.*which = size * tangent;
  minus.*which = -size * tangent;
  return (tracedError(mirror, plus, light, azimuth_rad) -
          tracedError(mirror, minus, light, azimuth_rad)) /
         (2.0 * size);
}

TEST(ConicMirror, MisalignmentAgreesWithTheRayTrace) {
  const ConicMirror mirror = defaultMirror();
  for (double distance : {0.3, 1.0, 5.0}) {
    for (double height : {-0.05, -0.03, 0.01}) {
      const LightPlace light{distance, height};
      const MisalignmentCoefficients coefficients = misalignment(mirror, light);
      for (double azimuth : {0.0, 0.7, 2.9}) {
        const double tilt =
            tracedCoefficient(mirror, light, azimuth, &test::ConeMisalignment::tilt, 1e-5);
        EXPECT_NEAR(coefficients.tilt / tilt, 1.0, 1e-3) << distance << " m, height " << height;
        const double offset =
            tracedCoefficient(mirror, light, azimuth, &test::ConeMisalignment::offset_m, 1e-7);
        EXPECT_NEAR(coefficients.offset / offset, 1.0, 1e-3) << distance << " m, height " << height;
      }
    }
  }
}

// A wrong centre moves every pixel by -u: the azimuth turns by -u_t / R.
TEST(ConicMirror, AWrongCentreTurnsTheAzimuth) {
  const ConicMirror mirror = defaultMirror();
  const LightPlace light{1.0, kDefaultLightHeight_m};
  const double radius = *radiusFromLight(mirror, light);
  constexpr double kShift_px = 1e-3;
  const MirrorPixel seen = mirrorPixelFromImage({0.0, kShift_px, 1}, radius, 0.0);
  // Down on the screen is -y of the sensor, and w_t = w_y at azimuth 0.
  EXPECT_NEAR(seen.azimuth_rad, misalignment(mirror, light).centre * -kShift_px, 1e-9);
}

TEST(ConicMirror, ValidateNamesEveryWrongValue) {
  EXPECT_TRUE(errorsOf(defaultMirror()).empty());
  ConicMirror focused_at_infinity = defaultMirror();
  focused_at_infinity.focus_distance_m = kInfinity;
  EXPECT_TRUE(errorsOf(focused_at_infinity).empty());
  EXPECT_EQ(errorsOf(ConicMirror()).size(), 7u);
}

}  // namespace
}  // namespace bearing_calibration::core
