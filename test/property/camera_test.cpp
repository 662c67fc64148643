// The rays of cameras without a mirror, against OpenCV's projections.

#include "bearing_calibration/optics/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <ostream>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct KnownCamera {
  const char* name;
  Camera camera;
  double widest_rad;  ///< that is looked at
};

void PrintTo(const KnownCamera& known, std::ostream* stream) { *stream << known.name; }

Camera camera(Lens lens, double focal_px, const std::array<double, 8>& distortion) {
  Camera result;
  result.focal_u_px = focal_px;
  result.focal_v_px = 1.03 * focal_px;
  result.centre_u_px = 331.0;
  result.centre_v_px = 228.5;
  result.lens = lens;
  result.distortion = distortion;
  return result;
}

const Camera kPinhole = camera(Lens::kPerspective, 400.0, {});
const Camera kPlumbBob =
    camera(Lens::kPerspective, 400.0, {-0.28, 0.09, 1.5e-3, -8e-4, -0.01, 0, 0, 0});
const Camera kRational =
    camera(Lens::kPerspective, 300.0, {2.1, 0.6, -4e-4, 3e-4, 0.02, 2.4, 1.1, 0.12});
const Camera kFisheye = camera(Lens::kFisheye, 180.0, {0.03, -0.012, 0.004, -0.0008, 0, 0, 0, 0});

/// By OpenCV, whose fisheye ends at 90 deg.
Vector2d projectedByOpenCv(const Camera& camera, const Vector3d& ray) {
  const std::vector<cv::Point3d> points{{ray.x(), ray.y(), ray.z()}};
  const cv::Matx33d K(camera.focal_u_px, 0, camera.centre_u_px, 0, camera.focal_v_px,
                      camera.centre_v_px, 0, 0, 1);
  const auto& d = camera.distortion;
  const cv::Vec3d zero(0, 0, 0);
  std::vector<cv::Point2d> pixels;
  if (camera.lens == Lens::kFisheye) {
    cv::fisheye::projectPoints(points, pixels, zero, zero, K, cv::Vec4d(d[0], d[1], d[2], d[3]));
  } else {
    cv::projectPoints(points, zero, zero, K, std::vector<double>(d.begin(), d.end()), pixels);
  }
  return {pixels.front().x, pixels.front().y};
}

Vector3d rayAt(double off_axis_rad, double around_rad) {
  return {std::sin(off_axis_rad) * std::cos(around_rad),
          std::sin(off_axis_rad) * std::sin(around_rad), std::cos(off_axis_rad)};
}

class KnownCameras : public testing::TestWithParam<KnownCamera> {
 protected:
  std::vector<Vector3d> rays(double widest_rad) const {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> part(0.0, 1.0);
    std::vector<Vector3d> result{Vector3d::UnitZ()};
    for (int i = 0; i < 500; ++i) {
      result.push_back(rayAt(widest_rad * part(random), 2.0 * kPi * part(random)));
    }
    return result;
  }
};

TEST_P(KnownCameras, ProjectAsOpenCvDoes) {
  const double widest_rad = std::min(GetParam().widest_rad, radiansFromDegrees(89.0));
  for (const Vector3d& ray : rays(widest_rad)) {
    const auto pixel = pixelFromRay(GetParam().camera, 3.0 * ray);
    ASSERT_TRUE(pixel) << ray.transpose();
    EXPECT_LT((*pixel - projectedByOpenCv(GetParam().camera, ray)).norm(), 1e-9);
  }
}

TEST_P(KnownCameras, FindTheRayOfAPixel) {
  for (const Vector3d& ray : rays(GetParam().widest_rad)) {
    const auto pixel = pixelFromRay(GetParam().camera, ray);
    ASSERT_TRUE(pixel) << ray.transpose();
    const auto found = rayFromPixel(GetParam().camera, *pixel);
    ASSERT_TRUE(found) << ray.transpose();
    EXPECT_LT((*found - ray).norm(), 1e-9) << ray.transpose();
  }
}

TEST_P(KnownCameras, HaveTheDirectionsOfTheirRays) {
  Camera turned = GetParam().camera;
  turned.sensor_from_optical =
      Eigen::AngleAxisd(0.3, Vector3d(0.2, -0.5, 0.1).normalized()) * turned.sensor_from_optical;
  constexpr double kStep_rad = 1e-5;
  for (const Vector3d& ray : rays(GetParam().widest_rad)) {
    const Vector3d v = turned.sensor_from_optical * ray;
    const double across = v.head<2>().norm();
    if (across < 0.1) continue;  // near the sensor's z axis no azimuth is linear over a pixel
    const Vector2d pixel = *pixelFromRay(turned, ray);
    const auto direction = directionFromPixel(turned, pixel);
    ASSERT_TRUE(direction) << ray.transpose();
    EXPECT_NEAR(direction->azimuth_rad, std::atan2(v.y(), v.x()), 1e-8);
    EXPECT_NEAR(direction->elevation_rad, std::asin(v.z()), 1e-8);
    // A small turn of the ray about z changes the azimuth alone, one upwards the elevation alone.
    const Vector3d sideways = Vector3d(-v.y(), v.x(), 0.0);
    const Vector3d upwards = Vector3d(0, 0, 1).cross(v).normalized().cross(-v);
    for (int i : {0, 1}) {
      const Vector3d moved = v + kStep_rad * (i == 0 ? sideways : upwards);
      const Vector2d change =
          (*pixelFromRay(turned, turned.sensor_from_optical.transpose() * moved) - pixel) /
          kStep_rad;
      const Vector2d turn = direction->J_direction_pixel * change;
      EXPECT_LT((turn - Vector2d::Unit(i)).norm(), 2e-3) << ray.transpose();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, KnownCameras,
    testing::Values(KnownCamera{"pinhole", kPinhole, radiansFromDegrees(60.0)},
                    KnownCamera{"plumb_bob", kPlumbBob, radiansFromDegrees(45.0)},
                    KnownCamera{"rational_polynomial", kRational, radiansFromDegrees(60.0)},
                    KnownCamera{"equidistant", kFisheye, radiansFromDegrees(110.0)}),
    [](const auto& known) { return known.param.name; });

TEST(Camera, LooksAlongTheSensorsXAxisWithoutBeingTold) {
  const auto ahead = directionFromPixel(kPinhole, {331.0, 228.5});
  EXPECT_NEAR(ahead->azimuth_rad, 0.0, 1e-12);
  EXPECT_NEAR(ahead->elevation_rad, 0.0, 1e-12);
  const auto right_and_up = directionFromPixel(kPinhole, {331.0 + 400.0, 228.5 - 412.0});
  EXPECT_NEAR(right_and_up->azimuth_rad, -0.25 * kPi, 1e-12);
  EXPECT_NEAR(right_and_up->elevation_rad, std::atan(1.0 / std::sqrt(2.0)), 1e-12);
}

// r (1 + k1 r^2 + k2 r^4) grows up to 0.756 at r = 1.214, shrinks, and grows again from 2.128 on.
TEST(Camera, ShowsNothingWhereItsImageWouldGoBack) {
  const Camera barrel = camera(Lens::kPerspective, 1.0, {-0.3, 0.03, 0, 0, 0, 0, 0, 0});
  const auto rayAtLength = [&](double length) {
    return rayFromPixel(barrel, {barrel.centre_u_px + length, barrel.centre_v_px});
  };
  EXPECT_TRUE(rayAtLength(0.755));
  for (double length : {0.757, 0.8, 1.0, 3.0, 100.0}) EXPECT_FALSE(rayAtLength(length)) << length;
  EXPECT_TRUE(pixelFromRay(barrel, {1.21, 0.0, 1.0}));
  EXPECT_FALSE(pixelFromRay(barrel, {1.22, 0.0, 1.0}));
  EXPECT_FALSE(pixelFromRay(barrel, {3.0, 0.0, 1.0}));
  EXPECT_FALSE(pixelFromRay(barrel, {0.1, 0.0, -1.0})) << "behind";
}

// t (1 + k1 t^2) with k1 = -0.1 grows up to 1.217 at t = 1.826; without distortion t ends at pi.
TEST(Camera, OfAFisheyeEndsToo) {
  const auto rayAtLength = [](double k1, double length) {
    const Camera fisheye = camera(Lens::kFisheye, 1.0, {k1, 0, 0, 0, 0, 0, 0, 0});
    return rayFromPixel(fisheye, {fisheye.centre_u_px, fisheye.centre_v_px + 1.03 * length});
  };
  EXPECT_TRUE(rayAtLength(-0.1, 1.216));
  EXPECT_LT(rayAtLength(-0.1, 1.216)->z(), 0.0) << "1.79 rad off the axis";
  EXPECT_FALSE(rayAtLength(-0.1, 1.218));
  EXPECT_TRUE(rayAtLength(0.0, 3.14));
  EXPECT_FALSE(rayAtLength(0.0, 3.15));
}

// t (1 + k4 t^8) with k4 = -0.001 grows up to t = 1.802.
TEST(Camera, OfAFisheyeEndsByItsLastCoefficientToo) {
  const Camera fisheye = camera(Lens::kFisheye, 1.0, {0, 0, 0, -0.001, 0, 0, 0, 0});
  EXPECT_TRUE(pixelFromRay(fisheye, rayAt(1.80, 0.3)));
  EXPECT_FALSE(pixelFromRay(fisheye, rayAt(1.81, 0.3)));
}

TEST(Camera, OfAFisheyeShowsNothingStraightBehindIt) {
  const Camera fisheye = camera(Lens::kFisheye, 1.0, {});
  EXPECT_TRUE(pixelFromRay(fisheye, {0.0, 0.0, 1.0}));
  EXPECT_TRUE(pixelFromRay(fisheye, {1e-3, 0.0, -1.0}));
  EXPECT_FALSE(pixelFromRay(fisheye, {0.0, 0.0, -1.0}));
}

TEST(Camera, IsNoneWithoutItsNumbers) {
  EXPECT_EQ(whyNoCamera(kPlumbBob), "");
  EXPECT_NE(whyNoCamera(Camera()).find("K[0]"), std::string::npos) << "zeros";
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Camera broken = kPlumbBob;
  broken.focal_v_px = kNan;
  EXPECT_NE(whyNoCamera(broken), "");
  broken = kPlumbBob;
  broken.centre_v_px = kNan;
  EXPECT_NE(whyNoCamera(broken).find("K[5]"), std::string::npos);
  broken = kPlumbBob;
  broken.distortion[7] = kNan;
  EXPECT_NE(whyNoCamera(broken).find("D"), std::string::npos);
  EXPECT_FALSE(kPlumbBob == kRational);
}

constexpr int kWidth_px = 640;
constexpr int kHeight_px = 480;
constexpr double kGrid_rad = radiansFromDegrees(0.5);

/// Azimuth of what OpenCV says that a pixel of a level camera shows.
double azimuthByOpenCv(const Camera& camera, const Vector2d& pixel) {
  const std::vector<cv::Point2d> pixels{{pixel.x(), pixel.y()}};
  const cv::Matx33d K(camera.focal_u_px, 0, camera.centre_u_px, 0, camera.focal_v_px,
                      camera.centre_v_px, 0, 0, 1);
  const auto& d = camera.distortion;
  std::vector<cv::Point2d> straight;
  if (camera.lens == Lens::kFisheye) {
    cv::fisheye::undistortPoints(pixels, straight, K, cv::Vec4d(d[0], d[1], d[2], d[3]));
  } else {
    cv::undistortPoints(pixels, straight, K, std::vector<double>(d.begin(), d.end()));
  }
  return -std::atan(straight.front().x);
}

/// The first and the last column at the height of the lens are its borders.
TEST(ViewOf, ALevelCameraIsItsImagesWidth) {
  Camera narrow_fisheye = kFisheye;  // OpenCV's inverse ends at 90 deg
  narrow_fisheye.focal_u_px = narrow_fisheye.focal_v_px = 400.0;
  for (const Camera& known : {kPinhole, kPlumbBob, kRational, narrow_fisheye}) {
    const double left_rad = azimuthByOpenCv(known, {0.0, known.centre_v_px});
    const double right_rad = azimuthByOpenCv(known, {kWidth_px - 1.0, known.centre_v_px});
    const FieldOfView view = viewOf(known, kWidth_px, kHeight_px);
    EXPECT_NEAR(view.centre_rad + 0.5 * view.width_rad, left_rad, 2.0 * kGrid_rad);
    EXPECT_NEAR(view.centre_rad - 0.5 * view.width_rad, right_rad, 2.0 * kGrid_rad);
  }
}

TEST(ViewOf, ATurnedCameraIsTurned) {
  Camera turned = kPinhole;
  const double yaw_rad = 3.0;  // across the end of the turn
  turned.sensor_from_optical =
      Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()) * kPinhole.sensor_from_optical;
  const FieldOfView level = viewOf(kPinhole, kWidth_px, kHeight_px);
  const FieldOfView view = viewOf(turned, kWidth_px, kHeight_px);
  EXPECT_NEAR(view.width_rad, level.width_rad, 2.0 * kGrid_rad);
  EXPECT_NEAR(wrapAngle(view.centre_rad - level.centre_rad - yaw_rad), 0.0, kGrid_rad);
}

/// Looking down by 30 deg it shows the horizon no more, but what lies a little below.
TEST(ViewOf, ATiltedCameraIsItsNearestElevation) {
  Camera tilted = kPinhole;
  tilted.focal_v_px = 600.0;  // 21 deg over the axis
  tilted.sensor_from_optical =
      Eigen::AngleAxisd(radiansFromDegrees(30.0), Vector3d::UnitY()) * kPinhole.sensor_from_optical;
  const FieldOfView view = viewOf(tilted, kWidth_px, kHeight_px);
  const auto borderAt = [&](double elevation_rad, double sense) {
    double border_rad = 0.0;
    for (double azimuth_rad = 0.0; azimuth_rad < 0.5 * kPi; azimuth_rad += 1e-3) {
      const Vector3d ray(std::cos(sense * azimuth_rad) * std::cos(elevation_rad),
                         std::sin(sense * azimuth_rad) * std::cos(elevation_rad),
                         std::sin(elevation_rad));
      const Vector2d pixel =
          projectedByOpenCv(tilted, tilted.sensor_from_optical.transpose() * ray);
      if (pixel.x() < 0.0 || pixel.x() > kWidth_px - 1.0 || pixel.y() < 0.0) break;
      border_rad = sense * azimuth_rad;
    }
    return border_rad;
  };
  EXPECT_EQ(borderAt(-0.1, 1.0), 0.0) << "not shown straight ahead";
  EXPECT_NEAR(view.centre_rad + 0.5 * view.width_rad, borderAt(-0.2, 1.0), 2.0 * kGrid_rad);
  EXPECT_NEAR(view.centre_rad - 0.5 * view.width_rad, borderAt(-0.2, -1.0), 2.0 * kGrid_rad);
}

/// Up, a fisheye of a half sphere shows the horizon all around; down, a narrow lens shows none.
TEST(ViewOf, ACameraThatLooksUpOrDownIsNotLimited) {
  Camera up = kFisheye;
  up.focal_u_px = up.focal_v_px = 130.0;
  up.centre_u_px = 0.5 * (kWidth_px - 1);
  up.centre_v_px = 0.5 * (kHeight_px - 1);
  up.sensor_from_optical = Eigen::AngleAxisd(0.1, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_FALSE(viewOf(up, kWidth_px, kHeight_px).isLimited());
  Camera down = kPinhole;
  down.sensor_from_optical = Eigen::AngleAxisd(kPi, Vector3d::UnitX()).toRotationMatrix();
  EXPECT_FALSE(viewOf(down, kWidth_px, kHeight_px).isLimited());
}

}  // namespace
}  // namespace bearing_calibration::core
