// What a scene's parts do to an image, against what theory expects of them.

#include "bearing_calibration/simulation/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <set>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "tools/study/random_scene.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

constexpr double kTurn_radps = 1.0;
constexpr double kRowTime_s = 30e-6;
constexpr double kExposure_s = 5e-3;

double darkness(double, double) { return 0.0; }

RendererConfig darkConfig() {
  RendererConfig config;
  config.outside_mirror = 0.0;
  config.centre_brightness = 0.0;
  return config;
}

Light lightOf(const RendererConfig& config) {
  Light light;
  light.height_m = config.reference_height_m;
  return light;
}

/// A sensor 1 m from the light at the origin, which it sees at `azimuth_rad` at time 0.
SensorMotion turning(double azimuth_rad, double turn_radps) {
  SensorMotion motion;
  motion.world_from_sensor = {{-1.0, 0.0}, wrapAngle(-azimuth_rad)};
  motion.turn_radps = turn_radps;
  return motion;
}

double azimuthOfPixel(const CameraRig& rig, const Vector2d& pixel) {
  return rig.handedness *
         std::atan2(-(pixel.y() - rig.centre_px.y()), pixel.x() - rig.centre_px.x());
}

struct ImageMoments {
  double sum = 0.0;
  Vector2d mean = Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

ImageMoments momentsOf(const CameraRig& rig, const std::vector<float>& electrons) {
  ImageMoments moments;
  const auto width = static_cast<std::size_t>(rig.width_px);
  const auto visit = [&](const auto& add) {
    for (std::size_t i = 0; i < electrons.size(); ++i) {
      if (electrons[i] > 0.0F) {
        add(static_cast<double>(electrons[i]),
            Vector2d(static_cast<double>(i % width), static_cast<double>(i / width)));
      }
    }
  };
  visit([&](double value, const Vector2d& pixel) {
    moments.sum += value;
    moments.mean += value * pixel;
  });
  moments.mean /= moments.sum;
  visit([&](double value, const Vector2d& pixel) {
    const Vector2d offset = pixel - moments.mean;
    moments.covariance += value / moments.sum * offset * offset.transpose();
  });
  return moments;
}

// A blur of w = turn * exposure adds (radius * w)^2 / 12 along the tangent, and moves nothing.
TEST(MotionBlur, WidensTheSpotAlongTheTangent) {
  constexpr double kFast_radps = 10.0;  // 8 px of blur
  RendererConfig config = darkConfig();
  config.rays_per_light = 1 << 15;
  ImageRenderer still(config, darkness);
  config.shutter.exposure_s = kExposure_s;
  ImageRenderer blurred(config, darkness);
  for (double azimuth : {-2.5, 0.3, 1.4}) {
    const SensorMotion motion = turning(azimuth, kFast_radps);
    const auto before =
        momentsOf(config.rig, still.expose({lightOf(config)}, {motion.world_from_sensor}));
    const auto after = momentsOf(config.rig, blurred.expose({lightOf(config)}, motion));
    const Vector2d from_centre = before.mean - config.rig.centre_px;
    const Vector2d tangent = perpendicular(from_centre.normalized());
    const double width_px = from_centre.norm() * kFast_radps * kExposure_s;
    const double widening = tangent.dot((after.covariance - before.covariance) * tangent);
    EXPECT_NEAR(widening / (width_px * width_px / 12.0), 1.0, 0.02);
    EXPECT_NEAR(after.sum / before.sum, 1.0, 1e-3);
    const double shift_rad =
        wrapAngle(azimuthOfPixel(config.rig, after.mean) - azimuthOfPixel(config.rig, before.mean));
    EXPECT_NEAR(degreesFromRadians(shift_rad), 0.0, 1e-3);
  }
}

// The spot's centroid lies where the light was when its row was exposed.
TEST(RollingShutter, ShowsTheLightWhereItWasAtItsRow) {
  RendererConfig config = darkConfig();
  config.rays_per_light = 1 << 15;
  config.shutter.row_time_s = kRowTime_s;
  ImageRenderer renderer(config, darkness);
  for (double azimuth : {-2.5, -1.0, 0.3, 1.4, 3.0}) {
    const SensorMotion motion = turning(azimuth, kTurn_radps);
    const auto spot = momentsOf(config.rig, renderer.expose({lightOf(config)}, motion));
    const auto truth = renderer.truthOf(lightOf(config), motion);
    ASSERT_TRUE(truth);
    EXPECT_NEAR(truth->time_s, truth->pixel.y() * kRowTime_s, 1e-9);
    EXPECT_NEAR(wrapAngle(truth->azimuth_rad - azimuth), -kTurn_radps * truth->time_s, 1e-12);
    const double row_s = spot.mean.y() * kRowTime_s;
    const double expected = azimuth - kTurn_radps * row_s;
    EXPECT_NEAR(degreesFromRadians(wrapAngle(azimuthOfPixel(config.rig, spot.mean) - expected)),
                0.0, 2e-3);
    EXPECT_NEAR(std::atan2(config.reference_height_m, 1.0), truth->elevation_rad, 1e-12);
  }
}

TEST(RollingShutter, SkewsTheSurroundings) {
  RendererConfig config;
  config.rig.aperture_m = 1e-6;  // no defocus
  config.shutter = {kExposure_s, kRowTime_s};
  constexpr double kFast_radps = 5.0;
  constexpr double kWaves = 3.0;
  const auto radiance = [](double azimuth, double) {
    return 0.2 + 0.1 * std::sin(kWaves * azimuth);
  };
  ImageRenderer renderer(config, radiance);
  SensorMotion motion = turning(0.7, kFast_radps);
  const auto& electrons = renderer.expose({}, motion);
  // The mean of a sine over a width of 2 h is smaller by sin(h) / h.
  const double half_width = 0.5 * kWaves * kFast_radps * kExposure_s;
  for (std::size_t i = 0; i < electrons.size(); i += 37) {
    const Vector2d pixel(static_cast<double>(i % 640), static_cast<double>(i / 640));
    if ((pixel - config.rig.centre_px).norm() < config.centre_radius_px) continue;
    if (!renderer.tracer().directionSeenBy(pixel)) continue;
    const double world_rad =
        azimuthOfPixel(config.rig, pixel) - 0.7 + kFast_radps * pixel.y() * kRowTime_s;
    const double expected =
        12000.0 * (0.2 + 0.1 * std::sin(half_width) / half_width * std::sin(kWaves * world_rad));
    // Lines between columns (0.05, as without a shutter); nine samples stand for the sweep.
    ASSERT_NEAR(static_cast<double>(electrons[i]), expected, 0.2) << pixel.transpose();
  }
}

TEST(SensorMotion, GoesFromPoseToPose) {
  const Pose2 start{{1.0, 2.0}, 3.0};
  const Pose2 end{{1.05, 2.02}, wrapAngle(3.3)};
  const SensorMotion motion = motionBetween(start, end, 0.25);
  EXPECT_LT((motion.poseAt(0.25).position_m - end.position_m).norm(), 1e-12);
  EXPECT_NEAR(wrapAngle(motion.poseAt(0.25).yaw_rad - end.yaw_rad), 0.0, 1e-12);
  EXPECT_LT((motion.poseAt(0.0).position_m - start.position_m).norm(), 1e-12);
}

TEST(Shutter, OfNoTimeIsAStillImage) {
  const RendererConfig config;
  ImageRenderer renderer(config, roomRadiance({}));
  const SensorMotion motion = turning(1.0, kTurn_radps);
  const cv::Mat still = renderer.render({lightOf(config)}, {motion.world_from_sensor}, 3);
  EXPECT_EQ(cv::norm(renderer.render({lightOf(config)}, motion, 3), still, cv::NORM_INF), 0.0);
}

TEST(MirrorHolders, HideTheirSectorAlone) {
  RendererConfig config = darkConfig();
  const auto grey = [](double, double) { return 0.5; };
  ImageRenderer open(config, grey);
  config.holders = {{0.5, 0.05}, {-2.6, 0.02}};
  ImageRenderer held(config, grey);
  const std::vector<float> before = open.expose({}, {});
  const std::vector<float> after = held.expose({}, {});
  for (std::size_t i = 0; i < before.size(); i += 11) {
    if (before[i] <= 0.0F) continue;
    const Vector2d pixel(static_cast<double>(i % 640), static_cast<double>(i / 640));
    const double azimuth = azimuthOfPixel(config.rig, pixel);
    const bool is_hidden =
        std::abs(wrapAngle(azimuth - 0.5)) < 0.05 || std::abs(wrapAngle(azimuth + 2.6)) < 0.02;
    ASSERT_EQ(after[i] < 0.1F * before[i], is_hidden) << pixel.transpose();
    if (!is_hidden) {
      ASSERT_EQ(after[i], before[i]);
    }
  }
}

// The mosaic's name is its first two rows.
TEST(ImageEncoding, EveryMosaicHasItsColoursInPlace) {
  RendererConfig config = darkConfig();
  config.pixels.read_noise_electrons = 0.0;
  config.encoding.red_response = 0.5;
  config.encoding.blue_response = 0.25;
  const auto grey = [](double, double) { return 0.4; };
  for (std::size_t layout = 1; layout + 1 < layoutNames().size(); ++layout) {
    config.encoding.layout = static_cast<ImageEncoding::Layout>(layout);
    ImageRenderer renderer(config, grey);
    const auto& electrons = renderer.expose({}, {});
    const std::string colours = layoutNames()[layout].substr(6, 4);
    const std::size_t corner = 240 * 640 + 440;  // even row and column, on the mirror
    const std::size_t places[] = {corner, corner + 1, corner + 640, corner + 641};
    for (std::size_t i = 0; i < 4; ++i) {
      const float response = colours[i] == 'r' ? 0.5F : colours[i] == 'b' ? 0.25F : 1.0F;
      EXPECT_NEAR(electrons[places[i]], 4800.0F * response, 1.0F) << layoutNames()[layout] << i;
    }
  }
}

TEST(ImageEncoding, ColourComesFromAnRggbMosaic) {
  ImageEncoding encoding;
  encoding.layout = ImageEncoding::Layout::kBgr8;
  cv::Mat1b image(4, 4, 60);
  for (int i : {0, 2, 8, 10}) image(i / 4, i % 4) = 200;  // red
  for (int i : {5, 7, 13, 15}) image(i / 4, i % 4) = 20;  // blue
  const cv::Mat colour = encode(image, encoding);
  ASSERT_EQ(colour.type(), CV_8UC3);
  EXPECT_EQ(colour.at<cv::Vec3b>(1, 2), cv::Vec3b(20, 60, 200));
  EXPECT_EQ(colour.at<cv::Vec3b>(2, 1), cv::Vec3b(20, 60, 200));
}

TEST(ImageEncoding, JpegChangesLittleAndAlwaysTheSame) {
  const RendererConfig config;
  ImageRenderer renderer(config, roomRadiance({}));
  const cv::Mat image = renderer.render({lightOf(config)}, {{{-1.0, 0.0}, 0.4}}, 1);
  ImageEncoding encoding;
  const cv::Mat plain = encode(image, encoding);
  encoding.jpeg_quality = 90;
  const cv::Mat packed = encode(image, encoding);
  EXPECT_EQ(cv::norm(packed, encode(image, encoding), cv::NORM_INF), 0.0);
  const double rms = cv::norm(plain, packed, cv::NORM_L2) / std::sqrt(640.0 * 480.0);
  EXPECT_GT(rms, 0.0);
  EXPECT_LT(rms, 5.0);  // levels; the largest step of quality 90 is 24, uniform: 24 / sqrt(12) = 7
}

TEST(ImageEncoding, RefusesAMosaicInJpeg) {
  ImageEncoding encoding;
  encoding.jpeg_quality = 90;
  EXPECT_TRUE(errorsOf(encoding).empty());
  encoding.layout = ImageEncoding::Layout::kBayerGrbg8;
  ASSERT_EQ(errorsOf(encoding).size(), 1U);
  EXPECT_NE(errorsOf(encoding).front().find("camera/jpeg_quality"), std::string::npos);
}

TEST(LedRing, KeepsTheLightsPlaceAndBrightnessOnAverage) {
  LedRing ring;
  ring.leds = 8;
  ring.brightness_spread = 0.1;
  Light light;
  light.position_m = {1.0, -2.0};
  light.brightness = 3.0;
  SceneRandom random(5);
  constexpr int kRings = 2000;
  double sum = 0.0;
  double square = 0.0;
  for (int i = 0; i < kRings; ++i) {
    Vector2d middle = Vector2d::Zero();
    for (const Light& led : drawLeds(light, ring, &random)) {
      EXPECT_NEAR((led.position_m - light.position_m).norm(), ring.radius_m, 1e-12);
      middle += led.position_m / ring.leds;
      const double relative = led.brightness * ring.leds / light.brightness - 1.0;
      sum += relative;
      square += relative * relative;
    }
    EXPECT_LT((middle - light.position_m).norm(), 1e-12);
  }
  constexpr double kCount = 8.0 * kRings;
  constexpr double kTail = 0.0005;
  EXPECT_LT(std::abs(sum), 3.5 * 0.1 * std::sqrt(kCount));
  EXPECT_GT(square / 0.01, chiSquareQuantile(kTail, kCount));
  EXPECT_LT(square / 0.01, chiSquareQuantile(1.0 - kTail, kCount));
  ring.leds = 0;
  EXPECT_EQ(drawLeds(light, ring, &random).size(), 1U);
}

TEST(RandomScene, IsTheSameForTheSameSeed) {
  const RandomSceneConfig config;
  const RandomScene first = randomScene(config, 11);
  EXPECT_EQ(cv::norm(randomScene(config, 11).image, first.image, cv::NORM_INF), 0.0);
  EXPECT_GT(cv::norm(randomScene(config, 12).image, first.image, cv::NORM_INF), 0.0);
  EXPECT_EQ(first.holders.size(), 3U);
  EXPECT_FALSE(isBehind(first.holders, first.light_azimuth_rad, radiansFromDegrees(3.0)));
}

TEST(Clutter, HoldsAsManyOfEachKindAsAskedFor) {
  ClutterConfig config;
  config.windows = {1, 2};
  config.lamps = {0, 1};
  config.reflections = config.papers = {0, 0};
  std::set<std::size_t> counts;
  SceneRandom random(3);
  for (int i = 0; i < 200; ++i) counts.insert(drawClutter(config, &random).shapes.size());
  EXPECT_EQ(counts, (std::set<std::size_t>{1, 2, 3}));
}

TEST(Clutter, NeverDarkensAWallButByItsTexture) {
  ClutterConfig config;
  config.texture_contrast = {0.0, 0.0};
  SceneRandom random(4);
  const auto wall = [](double, double) { return 0.1; };
  const RadianceFunction surroundings = withClutter(wall, drawClutter(config, &random));
  for (int i = 0; i < 1000; ++i) EXPECT_GE(surroundings(0.00628 * i, -0.05), 0.1);
}

TEST(Scene, ListsEveryWrongValue) {
  SceneConfig config;
  config.lights = {Light{{0.0, 0.0}, 0.0, -1.0, 0.0}};
  config.ring.leds = -1;
  config.room.contrast = 2.0;
  config.clutter.lamps = {3, 2};
  config.clutter.texture_contrast = {0.5, 1.5};
  EXPECT_EQ(errorsOf(config).size(), 5U);
  EXPECT_THROW(drawScene(config, 1), std::invalid_argument);
}

TEST(Scene, TurnsEachLightIntoARing) {
  SceneConfig config;
  config.lights = {Light{}, Light{}};
  config.ring.leds = 6;
  EXPECT_EQ(drawScene(config, 1).lights.size(), 12U);
}

}  // namespace
}  // namespace bearing_calibration::core
