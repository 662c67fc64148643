// The mirror's rim found in ray-traced images, blurred as the lens blurs the rim, and in
// photographs.

#include "bearing_calibration/vision/mirror_rim.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/simulation/image_renderer.h"
#include "support/default_rig.h"
#include "support/photographs.h"
#include "support/synthetic_spot.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

constexpr int kWidth_px = 640, kHeight_px = 480;
constexpr int kFine = 2;        // pixels of the fine image along a pixel's side
constexpr int kMargin_px = 60;  // of the fine image around the cut-out, which moves in it

/// Walls, windows and lamps, different at each seed.
RadianceFunction room(unsigned seed) {
  struct Patch {
    double azimuth_rad, half_width_rad, low_rad, brightness;
  };
  std::mt19937 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  std::vector<Patch> patches;
  for (int i = 0; i < 12; ++i) {
    patches.push_back(
        {between(-kPi, kPi), between(0.02, 0.4), between(-0.2, 0.1), between(0.02, 1.5)});
  }
  return [patches](double azimuth_rad, double elevation_rad) {
    double brightness = 0.08;
    for (const Patch& patch : patches) {
      if (std::abs(wrapAngle(azimuth_rad - patch.azimuth_rad)) < patch.half_width_rad &&
          elevation_rad > patch.low_rad) {
        brightness = patch.brightness;
      }
    }
    return brightness;
  };
}

/// The lens' blur at the rim as an evenly filled disc in fine pixels.
cv::Mat apertureDisc() {
  const ConicMirror mirror = test::defaultMirror();
  const double rim_m =
      mirror.lens_to_apex_m + mirror.base_radius_m / std::tan(mirror.half_angle_rad);
  const double diameter_px = kFine * mirror.aperture_m * imageDistancePx(mirror) *
                             (1.0 / mirror.focus_distance_m - 1.0 / rim_m);
  const int half = static_cast<int>(std::ceil(0.5 * diameter_px));
  cv::Mat disc = cv::Mat::zeros(2 * half + 1, 2 * half + 1, CV_32F);
  for (int v = -half; v <= half; ++v) {
    for (int u = -half; u <= half; ++u) {
      disc.at<float>(v + half, u + half) = std::hypot(u, v) <= 0.5 * diameter_px ? 1.0F : 0.0F;
    }
  }
  return disc / cv::sum(disc)[0];
}

struct RimImage {
  cv::Mat image;
  Vector2d centre_px;
};

/// Images of one room, seen by a sensor of a random yaw and mirror centre.
class RimCamera {
 public:
  explicit RimCamera(unsigned seed) : random_(seed), renderer_(rig(), room(seed)), seed_(seed) {}

  RimImage take() {
    std::uniform_real_distribution<double> yaw(-kPi, kPi);
    std::uniform_int_distribution<int> shift(0, 2 * kMargin_px);
    std::vector<float> electrons = renderer_.expose({}, {{{0.0, 0.0}, yaw(random_)}});
    const CameraRig fine = rig().rig;
    cv::Mat image(fine.height_px, fine.width_px, CV_32F, electrons.data());
    cv::Mat blurred;
    cv::filter2D(image, blurred, CV_32F, apertureDisc());
    const cv::Point corner(shift(random_), shift(random_));
    cv::Mat cut = blurred(cv::Rect(corner, cv::Size(kFine * kWidth_px, kFine * kHeight_px)));
    cv::Mat coarse;
    cv::resize(cut, coarse, cv::Size(kWidth_px, kHeight_px), 0.0, 0.0, cv::INTER_AREA);
    const std::vector<float> pixels(coarse.begin<float>(), coarse.end<float>());
    std::vector<std::uint8_t> values = digitize(pixels, PixelConfig(), seed_, ++number_);
    const Vector2d in_cut = fine.centre_px - Vector2d(corner.x, corner.y);
    // A coarse pixel's centre lies between its fine pixels.
    return {cv::Mat(kHeight_px, kWidth_px, CV_8U, values.data()).clone(),
            (in_cut - Vector2d::Constant(0.5 * (kFine - 1))) / kFine};
  }

 private:
  static RendererConfig rig() {
    RendererConfig config;
    config.rig.width_px = kFine * kWidth_px + 2 * kMargin_px;
    config.rig.height_px = kFine * kHeight_px + 2 * kMargin_px;
    config.rig.centre_px = {0.5 * (config.rig.width_px - 1), 0.5 * (config.rig.height_px - 1)};
    config.rig.pixel_m /= kFine;
    config.centre_radius_px *= kFine;
    return config;
  }

  std::mt19937 random_;
  ImageRenderer renderer_;
  std::uint64_t seed_;
  std::uint64_t number_ = 0;
};

/// The default detector for an image whose mirror stands there.
DetectorConfig configFor(const Vector2d& centre_px) {
  DetectorConfig config = test::defaultDetector();
  config.view.centre_u_px = centre_px.x();
  config.view.centre_v_px = centre_px.y();
  return config;
}

double normalisedSquare(const MirrorRim& rim, const Vector2d& error_px) {
  return error_px.dot(rim.covariance_px2.topLeftCorner<2, 2>().inverse() * error_px);
}

TEST(MirrorRim, IsFoundWithoutBiasAndItsCovarianceIsHonest) {
  constexpr unsigned kRooms = 6;
  constexpr int kImages = 6;
  constexpr double kTotal = kRooms * kImages;
  Vector2d sum = Vector2d::Zero(), variances = Vector2d::Zero();
  double nees = 0.0, squares_px2 = 0.0, radius_errors_px = 0.0;
  for (unsigned seed = 1; seed <= kRooms; ++seed) {
    RimCamera camera(seed);
    for (int i = 0; i < kImages; ++i) {
      const RimImage taken = camera.take();
      const auto rim = findMirrorRim(taken.image, rimSearchIn(taken.image));
      ASSERT_TRUE(rim) << "room " << seed << ", image " << i;
      const Vector2d error = rim->circle.centre_px - taken.centre_px;
      sum += error;
      variances += rim->covariance_px2.diagonal().head<2>();
      nees += normalisedSquare(*rim, error);
      squares_px2 += error.squaredNorm();
      radius_errors_px += rim->circle.radius_px - rimRadiusPx(test::defaultMirror());
    }
  }
  RecordProperty("nees", std::to_string(nees / kTotal));
  RecordProperty("rms_px", std::to_string(std::sqrt(squares_px2 / kTotal)));
  RecordProperty("radius_bias_px", std::to_string(radius_errors_px / kTotal));
  constexpr double kTail = 5e-4;
  EXPECT_LT(nees, chiSquareQuantile(1.0 - kTail, 2.0 * kTotal));
  EXPECT_GT(nees, chiSquareQuantile(kTail, 2.0 * kTotal));
  constexpr double kSigmas = 3.5;
  EXPECT_LT(std::abs(sum.x()), kSigmas * std::sqrt(variances.x()));
  EXPECT_LT(std::abs(sum.y()), kSigmas * std::sqrt(variances.y()));
  // A centre of 0.1 px is 0.03 deg of a bearing at a radius of 160 px: inside the calibrated floor.
  EXPECT_LT(std::sqrt(squares_px2 / kTotal), 0.1);
  // The blur moves a curved edge inwards by some hundredths of a pixel; nothing hangs on that.
  EXPECT_LT(std::abs(radius_errors_px / kTotal), 0.1);
}

// To a hundredth of a pixel, without noise: a parabola through three slopes misses the top of a
// smooth edge by some hundredths, up and down as the pixels fall, and there are 360 of them.
TEST(MirrorRim, OfAnEvenDiscIsItsOutline) {
  constexpr double kRadius_px = 150.0;
  constexpr double kExact_px = 0.01;
  const test::SpotDrawing disc{{322.3, 237.6}, 0.0, 2.0 * kRadius_px, 2.0 * kRadius_px, 120.0};
  cv::Mat expected = test::flatImage(kWidth_px, kHeight_px, 30.0);
  addSpot(&expected, disc);
  cv::Mat image;
  expected.convertTo(image, CV_8U);
  const auto rim = findMirrorRim(image, rimSearchIn(image));
  ASSERT_TRUE(rim);
  EXPECT_NEAR(rim->circle.centre_px.x(), disc.centre_px.x(), kExact_px);
  EXPECT_NEAR(rim->circle.centre_px.y(), disc.centre_px.y(), kExact_px);
  EXPECT_NEAR(rim->circle.radius_px, kRadius_px, kExact_px);
  EXPECT_EQ(rim->visible_part, 1.0);
}

TEST(MirrorRim, IsFoundWithPartsHidden) {
  RimCamera camera(11);
  for (const double bright : {0.0, 255.0}) {
    RimImage taken = camera.take();
    const cv::Point centre(cvRound(taken.centre_px.x()), cvRound(taken.centre_px.y()));
    cv::ellipse(taken.image, centre, {400, 400}, 0.0, 20.0, 100.0, cv::Scalar(bright), cv::FILLED);
    cv::ellipse(taken.image, centre, {400, 400}, 0.0, 200.0, 230.0, cv::Scalar(bright), cv::FILLED);
    const auto rim = findMirrorRim(taken.image, rimSearchIn(taken.image));
    ASSERT_TRUE(rim);
    const double distance2 = normalisedSquare(*rim, rim->circle.centre_px - taken.centre_px);
    EXPECT_LT(distance2, chiSquareQuantile(0.9999, 2.0));
    EXPECT_LT(rim->visible_part, 0.7) << "two sides of the image and 110 degrees are hidden";
  }
}

TEST(MirrorRim, IsNotFoundWhereNoneIs) {
  cv::Mat noise(kHeight_px, kWidth_px, CV_8U);
  cv::RNG(5).fill(noise, cv::RNG::NORMAL, 60.0, 8.0);
  EXPECT_FALSE(findMirrorRim(noise, rimSearchIn(noise)));
  for (const double level : {0.0, 255.0}) {
    const cv::Mat flat(kHeight_px, kWidth_px, CV_8U, cv::Scalar(level));
    EXPECT_FALSE(findMirrorRim(flat, rimSearchIn(flat)));
  }
  for (const cv::Size& size : {cv::Size(1, 1), cv::Size(2, 300)}) {
    const cv::Mat small(size, CV_8U, cv::Scalar(7));
    EXPECT_FALSE(findMirrorRim(small, rimSearchIn(small)));
  }
}

// Pixels are counted by their centres, from 0.
TEST(MirrorRim, IsSearchedAboutTheMiddleOfTheImage) {
  const RimSearch search = rimSearchIn(cv::Mat(5, 9, CV_8U));
  EXPECT_EQ(search.centre_px, Vector2d(4.0, 2.0));
}

TEST(MirrorRim, RefusesOtherImagesAndSearches) {
  EXPECT_THROW(findMirrorRim(cv::Mat(), rimSearchAround(test::defaultDetector())),
               std::invalid_argument);
  EXPECT_THROW(
      findMirrorRim(cv::Mat::zeros(9, 9, CV_8UC3), rimSearchAround(test::defaultDetector())),
      std::invalid_argument);
  const cv::Mat grey = cv::Mat::zeros(9, 9, CV_8U);
  EXPECT_THROW(findMirrorRim(grey, RimSearch{}), std::invalid_argument);
}

class MirrorCheckTest : public testing::Test {
 protected:
  MirrorCheckTest() {
    static const RimImage taken = RimCamera(3).take();  // slow, and never changed
    config_ = configFor(taken.centre_px);
    config_.alignment.centre_stddev_px = 0.05;
    rim_ = findMirrorRim(taken.image, rimSearchAround(config_)).value();
  }

  /// Inconsistent, and one sentence names this.
  void expectComplaint(const std::string& words) {
    const MirrorCheck check = checkMirror(rim_, config_);
    EXPECT_FALSE(check.consistent);
    EXPECT_TRUE(
        std::any_of(check.sentences.begin(), check.sentences.end(),
                    [&](const std::string& text) { return text.find(words) != std::string::npos; }))
        << words;
  }

  DetectorConfig config_;
  MirrorRim rim_;
};

TEST_F(MirrorCheckTest, ARightConfigurationAgrees) {
  const MirrorCheck check = checkMirror(rim_, config_);
  EXPECT_TRUE(check.consistent) << testing::PrintToString(check.sentences);
  EXPECT_EQ(check.sentences.size(), 2u);
}

TEST_F(MirrorCheckTest, AnotherCentreIsNamed) {
  config_.view.centre_u_px += 1.0;
  expectComplaint("set them to the rim's centre");
}

TEST_F(MirrorCheckTest, AnotherLensIsNamed) {
  config_.mirror.focal_length_m *= 1.05;
  expectComplaint("check lens/focal_length");
}

TEST_F(MirrorCheckTest, AMaskPastTheRimIsNamed) {
  config_.mask.outer_radius_px = 260.0;
  expectComplaint("mask/outer_radius is 260.0 px");
}

// The shorter side bounds what an image holds of a mirror: a longer one beside it changes nothing.
TEST(RimSearch, IsOfTheShorterSide) {
  const RimSearch square = rimSearchIn(cv::Mat::zeros(480, 480, CV_8U));
  for (const cv::Size& size : {cv::Size(854, 480), cv::Size(480, 854)}) {
    const RimSearch search = rimSearchIn(cv::Mat::zeros(size, CV_8U));
    EXPECT_EQ(search.radius_px.low, square.radius_px.low) << size;
    EXPECT_EQ(search.radius_px.high, square.radius_px.high) << size;
    EXPECT_EQ(search.max_centre_error_px, square.max_centre_error_px) << size;
  }
}

/// Two pictures of one parabolic mirror: the same rim, found apart. Its place was read off by eye.
TEST(PhotographedRim, OfAParabolicMirrorIsTheSameInBothPictures) {
  std::vector<MirrorRim> rims;
  for (const char* name : {"parabolic_mirror_01.png", "parabolic_mirror_04.png"}) {
    const cv::Mat image = test::photograph(name);
    if (image.empty()) GTEST_SKIP() << "BEARING_CALIBRATION_DATA is not set";
    const auto rim = findMirrorRim(image, rimSearchIn(image));
    ASSERT_TRUE(rim) << name;
    EXPECT_LT((rim->circle.centre_px - Vector2d(642.0, 521.0)).norm(), 3.0);
    EXPECT_NEAR(rim->circle.radius_px, 353.0, 3.0);
    rims.push_back(*rim);
  }
  rims[0].covariance_px2 += rims[1].covariance_px2;
  EXPECT_LT(normalisedSquare(rims[0], rims[0].circle.centre_px - rims[1].circle.centre_px),
            chiSquareQuantile(0.999, 2.0));
}

TEST(PhotographedRim, OfAHyperbolicMirrorInTheStreet) {
  const cv::Mat image = test::photograph("hyperbolic_mirror_road.jpg");
  if (image.empty()) GTEST_SKIP() << "BEARING_CALIBRATION_DATA is not set";
  const auto rim = findMirrorRim(image, rimSearchIn(image));
  ASSERT_TRUE(rim);
  EXPECT_LT((rim->circle.centre_px - Vector2d(490.0, 492.0)).norm(), 3.0);
  EXPECT_NEAR(rim->circle.radius_px, 480.0, 4.0);
}

}  // namespace
}  // namespace bearing_calibration::core
