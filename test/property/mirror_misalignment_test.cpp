// What a leaning and decentred mirror does to bearings, against a rim that is projected point by
// point and the coefficients that the ray trace confirms (conic_mirror_test).
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/optics/conic_mirror.h"
#include "support/default_rig.h"

namespace bearing_calibration::core {
namespace {

using test::defaultMirror;
using test::kDefaultLightHeight_m;

/// Centre of the circle of least squares through the rim's image [px, in sensor axes].
Eigen::Vector2d projectedRimCentre(const ConicMirror& mirror, const Eigen::Vector2d& lean,
                                   const Eigen::Vector2d& offset_m) {
  constexpr int kPoints = 360;
  const double over_apex_m = mirror.base_radius_m / std::tan(mirror.half_angle_rad);
  const Eigen::Vector3d axis = Eigen::Vector3d(lean.x(), lean.y(), 1.0).normalized();
  const Eigen::Vector3d across = axis.cross(Eigen::Vector3d::UnitY()).normalized();
  const Eigen::Vector3d apex(offset_m.x(), offset_m.y(), 0.0);
  Eigen::Matrix<double, kPoints, 3> terms;  // 2 u cu + 2 v cv + k = u^2 + v^2
  Eigen::Matrix<double, kPoints, 1> squares;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * kPi * i / kPoints;
    const Eigen::Vector3d point =
        apex + over_apex_m * axis +
        mirror.base_radius_m * (std::cos(angle) * across + std::sin(angle) * axis.cross(across));
    const Eigen::Vector2d image =
        imageDistancePx(mirror) * point.head<2>() / (mirror.lens_to_apex_m + point.z());
    terms.row(i) << 2.0 * image.x(), 2.0 * image.y(), 1.0;
    squares(i) = image.squaredNorm();
  }
  return Eigen::Vector3d(terms.householderQr().solve(squares)).head<2>();
}

TEST(MirrorMisalignment, NearnessHangsOnTheFarHarmonicWhateverLeanAndOffset) {
  constexpr double kLeast_m = 1.0;
  constexpr double kMost_m = 3.0;
  const ConicMirror mirror = defaultMirror();
  const MirrorMisalignment bend =
      mirrorMisalignment(mirror, kDefaultLightHeight_m, kLeast_m, kMost_m);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> lean(-2e-3, 2e-3);  // small: it is a first-order law
  std::uniform_real_distribution<double> offset(-1e-4, 1e-4);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d axis(lean(random), lean(random));
    const Eigen::Vector2d apex_m(offset(random), offset(random));
    const Eigen::Vector2d centre_px = bend.centre_part * projectedRimCentre(mirror, axis, apex_m);
    const auto harmonic = [&](double distance_m) -> Eigen::Vector2d {
      const auto by = misalignment(mirror, {distance_m, kDefaultLightHeight_m});
      return by.tilt * axis + by.offset * apex_m + by.centre * centre_px;
    };
    const Eigen::Vector2d near = (harmonic(kLeast_m) - harmonic(kMost_m)) / (1.0 - 1.0 / kMost_m);
    const Eigen::Vector2d far = harmonic(kLeast_m) - near;
    constexpr double kSecondOrder = 1e-5;  // rad m
    EXPECT_LT((near - bend.near_per_far_m * far).norm(), kSecondOrder) << far.transpose();
    EXPECT_GT(near.norm() + far.norm(), kSecondOrder);
  }
}

TEST(MirrorMisalignment, RefusesWhatTheMirrorCannotSee) {
  EXPECT_THROW(mirrorMisalignment(defaultMirror(), 0.0, 3.0, 1.0), std::invalid_argument);
  EXPECT_THROW(mirrorMisalignment(defaultMirror(), 0.0, 0.0, 1.0), std::invalid_argument);
  EXPECT_THROW(mirrorMisalignment(defaultMirror(), 1.0, 0.5, 3.0), std::invalid_argument);
}

}  // namespace
}  // namespace bearing_calibration::core
