// The ray trace through the conic mirror against closed forms: reflection, blur, misalignment,
// flux.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/light_spot.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRays = 4096;

/// A light at `azimuth_rad` in the sensor frame, `distance_m` from the mirror's axis.
Light lightAt(double distance_m, double azimuth_rad, double height_m = -0.03) {
  return {{distance_m * std::cos(azimuth_rad), distance_m * std::sin(azimuth_rad)}, height_m};
}

SpotMoments momentsOf(const CameraRig& rig, const Light& light) {
  return LightSpot(rig, kRays).moments(light);
}

double azimuthOfPixel(const CameraRig& rig, const Vector2d& pixel) {
  return rig.handedness *
         std::atan2(-(pixel.y() - rig.centre_px.y()), pixel.x() - rig.centre_px.x());
}

/// The chief ray of an aligned rig, from the mirror's straight profile in the plane of light and
/// axis.
struct ChiefRay {
  ChiefRay(const CameraRig& rig, double distance_m, double height_m) {
    const double tau = rig.cone_half_angle_rad;
    const Vector2d light(distance_m, height_m);
    const Vector2d lens(0.0, -rig.lens_to_apex_m);
    const Vector2d along(std::sin(tau), std::cos(tau));
    const Vector2d normal(std::cos(tau), -std::sin(tau));
    // Seen from the lens' mirror image the ray is straight.
    const Vector2d image_of_lens = lens - 2.0 * normal.dot(lens) * normal;
    const Vector2d ray = light - image_of_lens;
    const Vector2d hit = image_of_lens - normal.dot(image_of_lens) / normal.dot(ray) * ray;
    EXPECT_NEAR(along.x() * hit.y() - along.y() * hit.x(), 0.0, 1e-12);
    radius = hit.x();
    theta = std::atan2(hit.x(), hit.y() - lens.y());
    to_mirror = (hit - lens).norm();
    to_light = (light - hit).norm();
    const double inverse_sagittal =
        1.0 / to_light + (std::sin(2.0 * tau - theta) - std::sin(theta)) / radius;
    sagittal = 1.0 / inverse_sagittal;
  }
  double radius;     ///< of the hit on the mirror [m]
  double theta;      ///< against the optical axis
  double to_mirror;  ///< lens to mirror [m]
  double to_light;   ///< mirror to light [m]
  double sagittal;   ///< mirror to the virtual image of the azimuthal fan [m]
};

class RendererGeometry : public testing::Test {
 protected:
  std::mt19937 random_{20061};
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  CameraRig misalignedRig() {
    CameraRig rig;
    rig.axis_lean = {uniform(-0.03, 0.03), uniform(-0.03, 0.03)};
    rig.apex_offset_m = {uniform(-1e-3, 1e-3), uniform(-1e-3, 1e-3)};
    rig.handedness = uniform(0.0, 1.0) < 0.5 ? -1 : 1;
    return rig;
  }
};

// Forwards (Fermat's principle) and backwards (intersection and law of reflection) are separate
// ways: a far light's chief ray must come from where its pixel looks.
TEST_F(RendererGeometry, PixelLooksWhereItsLightIs) {
  constexpr double kFar_m = 1e6;  // the mirror's size is then 1e-7 rad
  for (int i = 0; i < 200; ++i) {
    const ConeTracer tracer(misalignedRig());
    // drawn one after the other: within a call the order would be the compiler's
    const double elevation_rad = uniform(-0.15, 0.02);
    const double azimuth_rad = uniform(-kPi, kPi);
    const Light light = lightAt(kFar_m, azimuth_rad, kFar_m * std::tan(elevation_rad));
    const auto hit = tracer.rayFrom(light.place_m(), Vector2d::Zero());
    ASSERT_TRUE(hit.has_value());
    const auto direction = tracer.directionSeenBy(hit->pixel);
    ASSERT_TRUE(direction.has_value());
    EXPECT_LT((*direction - light.place_m().normalized()).norm(), 2e-7);
  }
}

TEST_F(RendererGeometry, ChiefRayOfAnAlignedRigIsTheClosedForm) {
  for (int i = 0; i < 100; ++i) {
    const CameraRig rig;
    const double distance_m = uniform(0.3, 5.0);
    const double azimuth = uniform(-kPi, kPi);
    const ChiefRay chief(rig, distance_m, -0.03);
    const auto hit =
        ConeTracer(rig).rayFrom(lightAt(distance_m, azimuth).place_m(), Vector2d::Zero());
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR((hit->pixel - rig.centre_px).norm(), rig.pixelsPerSlope() * std::tan(chief.theta),
                1e-7);
    EXPECT_NEAR(wrapAngle(azimuthOfPixel(rig, hit->pixel) - azimuth), 0.0, 1e-10);
  }
}

TEST_F(RendererGeometry, HandednessMirrorsTheImage) {
  CameraRig rig;
  const Vector3d to_the_left(0.0, 1.0, -0.03);  // +y of the sensor
  rig.handedness = 1;
  EXPECT_LT(ConeTracer(rig).rayFrom(to_the_left, Vector2d::Zero())->pixel.y(), rig.centre_px.y());
  rig.handedness = -1;
  EXPECT_GT(ConeTracer(rig).rayFrom(to_the_left, Vector2d::Zero())->pixel.y(), rig.centre_px.y());
  const Vector3d in_front(1.0, 0.0, -0.03);  // +x of the sensor
  EXPECT_GT(ConeTracer(rig).rayFrom(in_front, Vector2d::Zero())->pixel.x(), rig.centre_px.x());
}

// d = (A v / p) |1/z_f - 1/z| with z the depth of the virtual image of each fan: its azimuthal fan
// comes from s1 + s_s along the ray, its radial fan from s1 + s2 and is foreshortened by cos theta.
TEST_F(RendererGeometry, BlurIsThatOfAnAstigmaticMirror) {
  for (double focus_distance_m : {0.06, 0.12, 1e6}) {
    for (double distance_m : {0.3, 0.5, 1.0, 2.0, 5.0}) {
      CameraRig rig;
      rig.focus_distance_m = focus_distance_m;
      const ChiefRay chief(rig, distance_m, -0.03);
      const double scale = rig.aperture_m * rig.pixelsPerSlope();
      const double focus = 1.0 / focus_distance_m;
      const double tangential =
          scale *
          std::abs(focus - 1.0 / ((chief.to_mirror + chief.sagittal) * std::cos(chief.theta)));
      const double radial =
          scale * std::abs(focus - std::cos(chief.theta) / (chief.to_mirror + chief.to_light));
      const SpotMoments spot = momentsOf(rig, lightAt(distance_m, 0.0));
      // A filled ellipse has standard deviations of a quarter of its diameters.
      EXPECT_NEAR(4.0 * std::sqrt(spot.covariance_px2(1, 1)), tangential, 0.1)
          << "D = " << distance_m << ", z_f = " << focus_distance_m;
      EXPECT_NEAR(4.0 * std::sqrt(spot.covariance_px2(0, 0)), radial, 0.1)
          << "D = " << distance_m << ", z_f = " << focus_distance_m;
    }
  }
}

TEST_F(RendererGeometry, CentroidAndAxisOfAnAlignedLightAreUnbiased) {
  for (int i = 0; i < 20; ++i) {
    const CameraRig rig;
    const double azimuth = uniform(-kPi, kPi);
    const SpotMoments spot = momentsOf(rig, lightAt(uniform(0.3, 5.0), azimuth));
    const double centroid = azimuthOfPixel(rig, spot.mean_px);
    EXPECT_NEAR(degreesFromRadians(wrapAngle(centroid - azimuth)), 0.0, 1e-3);
    const auto& c = spot.covariance_px2;
    const double axis =
        0.5 * std::atan2(2.0 * c(0, 1), c(0, 0) - c(1, 1));  // of the image's (u, v)
    // In the image the azimuth is that of (u, -v) times the handedness; an axis has no sign.
    EXPECT_NEAR(degreesFromRadians(0.5 * wrapAngle(2.0 * (-rig.handedness * axis - azimuth))), 0.0,
                0.1);
  }
}

/// d(azimuth of the centroid) / d(misalignment) in the middle, by a central difference.
template <typename Misalign>
double sensitivity(const Light& light, double amount, const Misalign& misalign) {
  CameraRig plus;
  CameraRig minus;
  misalign(&plus, amount);
  misalign(&minus, -amount);
  return wrapAngle(azimuthOfPixel(plus, momentsOf(plus, light).mean_px) -
                   azimuthOfPixel(minus, momentsOf(minus, light).mean_px)) /
         (2.0 * amount);
}

// d beta = 2 (cot tau - dz/D) alpha_t, alpha_t = -alpha_x sin beta + alpha_y cos beta: of the chief
// ray; the aperture's other rays move the centroid by less than the tolerance.
TEST_F(RendererGeometry, MirrorTiltTurnsTheBearingByItsClosedForm) {
  constexpr double kTilt = 1e-3;
  for (double distance_m : {0.5, 1.0, 3.0}) {
    for (double height_m : {-0.1, -0.03, 0.0}) {  // all of the lens sees them in the mirror
      const double tau = CameraRig().cone_half_angle_rad;
      const double expected = 2.0 * (1.0 / std::tan(tau) - height_m / distance_m);
      const double of_tilt_y =
          sensitivity(lightAt(distance_m, 0.0, height_m), kTilt,
                      [](CameraRig* rig, double a) { rig->axis_lean.y() = a; });
      const double of_tilt_x =
          sensitivity(lightAt(distance_m, 0.5 * kPi, height_m), kTilt,
                      [](CameraRig* rig, double a) { rig->axis_lean.x() = a; });
      EXPECT_NEAR(of_tilt_y / expected, 1.0, 1e-3) << "D = " << distance_m << ", dz " << height_m;
      EXPECT_NEAR(of_tilt_x / -expected, 1.0, 1e-3) << "D = " << distance_m << ", dz " << height_m;
    }
  }
}

// d beta = (1/rho_S - 1/D) c_t with 1/rho_S = (1 - s2 sin theta / D) / r.
TEST_F(RendererGeometry, ApexOffsetTurnsTheBearingByItsClosedForm) {
  constexpr double kOffset_m = 1e-5;
  for (double distance_m : {0.5, 1.0, 3.0}) {
    const ChiefRay chief(CameraRig(), distance_m, -0.03);
    const double expected =
        (1.0 - chief.to_light * std::sin(chief.theta) / distance_m) / chief.radius -
        1.0 / distance_m;
    const double actual = sensitivity(lightAt(distance_m, 0.0), kOffset_m,
                                      [](CameraRig* rig, double c) { rig->apex_offset_m.y() = c; });
    EXPECT_NEAR(actual / expected, 1.0, 3e-3) << "D = " << distance_m;
  }
}

// A narrow beam of solid angle Omega is (s1 + s2) wide in the radial fan and s2 (s1 + s_s) / s_s in
// the azimuthal fan when it reaches the lens, which stands askew by theta.
TEST_F(RendererGeometry, LensCollectsTheFluxOfAnAstigmaticBeam) {
  for (double distance_m : {0.3, 1.0, 4.0}) {
    const CameraRig rig;
    const ChiefRay chief(rig, distance_m, -0.03);
    const double radial_m = chief.to_mirror + chief.to_light;
    const double azimuthal_m = chief.to_light * (chief.to_mirror + chief.sagittal) / chief.sagittal;
    const double expected = std::cos(chief.theta) / (radial_m * azimuthal_m);
    const auto hit = ConeTracer(rig).rayFrom(lightAt(distance_m, 0.7).place_m(), Vector2d::Zero());
    EXPECT_NEAR(hit->throughput / expected, 1.0, 1e-9);
    const double lens_area = 0.25 * kPi * rig.aperture_m * rig.aperture_m;
    EXPECT_NEAR(momentsOf(rig, lightAt(distance_m, 0.7)).flux / (expected * lens_area), 1.0, 1e-3);
  }
}

// A ball of radius a at the distance D is a disc of radius a R / D across the line of sight, with a
// quarter of its square as variance, which the defocus' variance is added to.
TEST_F(RendererGeometry, LargeLightIsWider) {
  constexpr double kRadius_m = 0.005;  // 1 % of D: R is the same all over the disc to 0.1 %
  const auto tangentialVariance = [](double aperture_m, double radius_m) {
    CameraRig rig;
    rig.aperture_m = aperture_m;
    Light light = lightAt(0.5, 0.0);
    light.radius_m = radius_m;
    return momentsOf(rig, light).covariance_px2(1, 1);
  };
  const CameraRig rig;
  const double radius_px = rig.pixelsPerSlope() * std::tan(ChiefRay(rig, 0.5, -0.03).theta);
  const double expected = std::pow(radius_px * kRadius_m / 0.5, 2) / 4.0;
  EXPECT_NEAR(tangentialVariance(1e-7, kRadius_m) / expected, 1.0, 0.01);
  // Across, its height moves the image along the radius.
  const auto radiusOf = [&rig](double height_m) {
    return rig.pixelsPerSlope() * std::tan(ChiefRay(rig, 0.5, height_m).theta);
  };
  const double radial_px = 0.5 * (radiusOf(-0.03 + kRadius_m) - radiusOf(-0.03 - kRadius_m));
  Light ball = lightAt(0.5, 0.0);
  ball.radius_m = kRadius_m;
  CameraRig pinhole;
  pinhole.aperture_m = 1e-7;
  EXPECT_NEAR(momentsOf(pinhole, ball).covariance_px2(0, 0) / (0.25 * radial_px * radial_px), 1.0,
              0.01);
  // Drawn at random, the product of places on disc and lens would have the standard deviation
  // 2 s_disc s_lens / sqrt(N); an even spread has less.
  const double of_lens = tangentialVariance(rig.aperture_m, 0.0);
  EXPECT_NEAR(tangentialVariance(rig.aperture_m, kRadius_m), of_lens + expected,
              2.0 * std::sqrt(expected * of_lens / kRays));
}

TEST_F(RendererGeometry, WhatTheMirrorDoesNotReflectDoesNotArrive) {
  const CameraRig rig;
  const ConeTracer tracer(rig);
  EXPECT_FALSE(tracer.rayFrom({0.01, 0.0, 0.2}, Vector2d::Zero())) << "inside the cone";
  EXPECT_FALSE(tracer.rayFrom({1.0, 0.0, 0.5}, Vector2d::Zero())) << "above the rim's view";
  EXPECT_FALSE(tracer.directionSeenBy({0.0, 0.0})) << "past the mirror";
  EXPECT_TRUE(tracer.directionSeenBy(rig.centre_px + Vector2d(100.0, 0.0)));
}

TEST_F(RendererGeometry, ListsEveryWrongValueOfTheRig) {
  CameraRig rig;
  rig.focus_distance_m = 0.001;
  rig.handedness = 0;
  rig.cone_half_angle_rad = 2.0;
  rig.axis_lean.x() = NAN;
  EXPECT_EQ(errorsOf(rig).size(), 4U);
  EXPECT_THROW(ConeTracer{rig}, std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
