// A light in the images of a camera without a mirror, perspective or fisheye, drawn by OpenCV's
// projections, is found, becomes bearings, and calibrates a mount as well as the bound allows; in
// much of each drive it is out of view.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/sensed_drive.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::SensedDrive;

constexpr int kWidth_px = 320;
constexpr int kHeight_px = 240;
constexpr double kLightHeight_m = 0.3;  // over the camera
constexpr double kLight_levels = 150.0;
constexpr double kBackground_levels = 20.0;
constexpr double kInFocus_px = 0.8;     // standard deviation of the blur
constexpr double kOutOfFocus_px = 2.0;  // the same

const Matrix3d kLevel = Camera().sensor_from_optical;

/// 77 deg wide, looks 5 deg down and leans by 3 deg.
Camera perspective() {
  Camera camera{200.0, 202.0, 163.0, 117.5, Lens::kPerspective};
  camera.distortion = {-0.25, 0.08, 1e-3, -5e-4, -0.01};
  camera.sensor_from_optical = (Eigen::AngleAxisd(radiansFromDegrees(5.0), Vector3d::UnitY()) *
                                Eigen::AngleAxisd(radiansFromDegrees(-3.0), Vector3d::UnitX()))
                                   .toRotationMatrix() *
                               kLevel;
  return camera;
}

/// 176 deg wide, as far as it is drawn.
Camera fisheye() {
  Camera camera{95.0, 95.5, 158.0, 121.0, Lens::kFisheye};
  camera.distortion = {0.02, -0.005, 0.001, -2e-4};
  return camera;
}

/// Photographs a round light that faces the camera.
class Photographer {
 public:
  Photographer(const Camera& camera, double light_radius_m, double blur_px)
      : camera_(camera), light_radius_m_(light_radius_m), blur_px_(blur_px) {}

  cv::Mat photograph(const Vector3d& light_in_sensor, const ImageSensor& sensor,
                     std::mt19937* random) {
    cv::Mat levels = test::flatImage(kWidth_px, kHeight_px, kBackground_levels);
    for (const cv::Point2d& place : project(light_in_sensor)) addPoint(place, &levels);
    return exposeAround(levels, sensor, random);
  }

 private:
  static constexpr int kPoints = 200;

  /// Points of the light, evenly over its disc; none beside what the lens shows.
  std::vector<cv::Point2d> project(const Vector3d& light_in_sensor) {
    const Vector3d light = camera_.sensor_from_optical.transpose() * light_in_sensor;
    const double off_axis_rad = std::atan2(light.head<2>().norm(), light.z());
    const bool is_fisheye = camera_.lens == Lens::kFisheye;
    std::vector<cv::Point2d> pixels;
    if (off_axis_rad > radiansFromDegrees(is_fisheye ? 88.0 : 50.0)) return pixels;
    const Vector3d across = light.unitOrthogonal();
    const Vector3d up = light.normalized().cross(across);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < kPoints; ++i) {
      const double golden_rad = kPi * (3.0 - std::sqrt(5.0)) * i;
      const double radius_m = light_radius_m_ * std::sqrt((i + 0.5) / kPoints);
      const Vector3d point =
          light + radius_m * (std::cos(golden_rad) * across + std::sin(golden_rad) * up);
      points.emplace_back(point.x(), point.y(), point.z());
    }
    const cv::Matx33d K(camera_.focal_u_px, 0, camera_.centre_u_px, 0, camera_.focal_v_px,
                        camera_.centre_v_px, 0, 0, 1);
    const auto& d = camera_.distortion;
    const cv::Vec3d zero(0, 0, 0);
    if (is_fisheye) {
      cv::fisheye::projectPoints(points, pixels, zero, zero, K, cv::Vec4d(d[0], d[1], d[2], d[3]));
    } else {
      cv::projectPoints(points, zero, zero, K, cv::Vec<double, 5>(d[0], d[1], d[2], d[3], d[4]),
                        pixels);
    }
    // The exposure is long enough that its peak has about these levels, however small it is.
    const double area_px2 = kPi * std::pow(camera_.focal_u_px * light_radius_m_ / light.norm(), 2);
    const double blur_px2 = 2.0 * kPi * blur_px_ * blur_px_;
    level_of_point_ = kLight_levels * (area_px2 + blur_px2) / kPoints;
    return pixels;
  }

  void addPoint(const cv::Point2d& place, cv::Mat* levels) const {
    const auto gaussian = [this](double off_px) {
      return std::exp(-0.5 * std::pow(off_px / blur_px_, 2)) / (blur_px_ * std::sqrt(2.0 * kPi));
    };
    const cv::Rect spot = around(place);
    for (int v = spot.y; v < spot.br().y; ++v) {
      const double row = level_of_point_ * gaussian(v - place.y);
      for (int u = spot.x; u < spot.br().x; ++u) {
        levels->at<double>(v, u) += row * gaussian(u - place.x);
      }
    }
  }

  cv::Rect around(const cv::Point2d& place) const {
    constexpr double kReach = 5.0;  // standard deviations
    const int reach_px = cvCeil(kReach * blur_px_);
    const cv::Point middle(cvRound(place.x), cvRound(place.y));
    const cv::Point reach(reach_px, reach_px);
    return cv::Rect(middle - reach, middle + reach + cv::Point(1, 1)) &
           cv::Rect(0, 0, kWidth_px, kHeight_px);
  }

  /// Fresh noise where light is; that of the background is one of a few.
  cv::Mat exposeAround(const cv::Mat& levels, const ImageSensor& sensor, std::mt19937* random) {
    constexpr std::size_t kBackgrounds = 8;
    while (backgrounds_.size() < kBackgrounds) {
      backgrounds_.push_back(
          test::expose(test::flatImage(kWidth_px, kHeight_px, kBackground_levels), sensor, random));
    }
    cv::Mat image = backgrounds_[(*random)() % kBackgrounds].clone();
    std::vector<cv::Point> lit;
    cv::findNonZero(levels > kBackground_levels, lit);
    if (lit.empty()) return image;
    cv::Point first = lit.front();
    cv::Point last = lit.front();
    for (const cv::Point& pixel : lit) {
      first = {std::min(first.x, pixel.x), std::min(first.y, pixel.y)};
      last = {std::max(last.x, pixel.x), std::max(last.y, pixel.y)};
    }
    const cv::Rect spot(first, last + cv::Point(1, 1));
    test::expose(levels(spot), sensor, random).copyTo(image(spot));
    return image;
  }

  Camera camera_;
  double light_radius_m_;
  double blur_px_;  ///< standard deviation
  double level_of_point_ = 0.0;
  std::vector<cv::Mat> backgrounds_;
};

DetectorConfig detectorOf(const Camera& camera) {
  DetectorConfig config = test::shippedDetector();
  config.mirror_kind = MirrorKind::kNone;
  config.camera = camera;
  config.sensor.width_px = kWidth_px;
  config.sensor.height_px = kHeight_px;
  config.mask.last_row = kHeight_px - 1;
  config.light.brightness_spread = 0.0;
  config.alignment.elevation_stddev_rad = 0.0;
  return config;
}

void expectHonestAndNearTheBound(const Camera& camera) {
  const DetectorConfig config = detectorOf(camera);
  LightDetector detector(config);
  constexpr double kRadius_m = 0.03;
  Photographer photographer(camera, kRadius_m, kInFocus_px);
  double images = 0.0;
  double with_light = 0.0;
  testing::expectHonestAndNearTheBound([&](const SensedDrive& drive, Stamp stamp, double time_s,
                                           std::mt19937* random, auto&) {
    const Eigen::Vector2d place = drive.worldFromSensor(time_s).inverse() * Eigen::Vector2d::Zero();
    const cv::Mat image =
        photographer.photograph({place.x(), place.y(), kLightHeight_m}, config.sensor, random);
    const BearingSet set =
        bearingsFromLights(detector.detect(image).lights, ShutterConfig(), stamp, kHeight_px);
    images += 1.0;
    with_light += set.candidates.empty() ? 0.0 : 1.0;
    return set;
  });
  std::cout << "light in view in " << 100.0 * with_light / images << " % of the images\n";
}

/// Bearings of small lights in every part of the image: without an expected spot their standard
/// deviations are right to a quarter (detection.md). (The middle of a large light's image is
/// not the image of its middle, by some hundredths of a pixel.)
void expectHonestVariances(const Camera& camera, double widest_rad, double blur_px) {
  constexpr int kImages = 2000;
  constexpr double kPoint_m = 0.01;
  const DetectorConfig config = detectorOf(camera);
  LightDetector detector(config);
  Photographer photographer(camera, kPoint_m, blur_px);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> azimuth(-widest_rad, widest_rad);
  std::uniform_real_distribution<double> distance(0.7, 1.5);
  std::uniform_real_distribution<double> height(-0.2, 0.3);
  double azimuth_nees = 0.0;
  double elevation_nees = 0.0;
  int found = 0;
  for (int i = 0; i < kImages; ++i) {
    const double azimuth_rad = azimuth(random);
    const double distance_m = distance(random);
    const double height_m = height(random);
    const cv::Mat image = photographer.photograph(
        {distance_m * std::cos(azimuth_rad), distance_m * std::sin(azimuth_rad), height_m},
        config.sensor, &random);
    const std::vector<Detection>& lights = detector.detect(image).lights;
    if (lights.size() != 1) continue;
    const Bearing& bearing = lights.front().bearing;
    const double azimuth_error = wrapAngle(bearing.azimuth_rad - azimuth_rad);
    const double elevation_error = bearing.elevation_rad - std::atan2(height_m, distance_m);
    azimuth_nees += azimuth_error * azimuth_error / bearing.azimuth_variance_rad2;
    elevation_nees += elevation_error * elevation_error / bearing.elevation_variance_rad2;
    ++found;
  }
  EXPECT_GT(found, 0.95 * kImages) << "all but those that the image's edge cuts";
  std::cout << "NEES of azimuths " << azimuth_nees / found << ", of elevations "
            << elevation_nees / found << '\n';
  constexpr double kQuarter = 1.25;
  for (const double nees : {azimuth_nees, elevation_nees}) {
    EXPECT_GT(nees / found, 1.0 / (kQuarter * kQuarter));
    EXPECT_LT(nees / found, kQuarter * kQuarter);
  }
}

TEST(CameraBearings, OfAPerspectiveCameraHaveHonestVariances) {
  expectHonestVariances(perspective(), radiansFromDegrees(35.0), kInFocus_px);
  expectHonestVariances(perspective(), radiansFromDegrees(35.0), kOutOfFocus_px);
}

TEST(CameraBearings, OfAFisheyeHaveHonestVariances) {
  expectHonestVariances(fisheye(), radiansFromDegrees(85.0), kInFocus_px);
  expectHonestVariances(fisheye(), radiansFromDegrees(85.0), kOutOfFocus_px);
}

TEST(CameraBearings, OfAPerspectiveCameraAreAsGoodAsTheySay) {
  expectHonestAndNearTheBound(perspective());
}

TEST(CameraBearings, OfAFisheyeAreAsGoodAsTheySay) { expectHonestAndNearTheBound(fisheye()); }

}  // namespace
}  // namespace bearing_calibration::core
