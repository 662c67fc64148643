#include "bearing_calibration/vision/light_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <new>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <random>
#include <set>

#include "bearing_calibration/common/angle.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"

namespace {
std::size_t allocations = 0;
}  // namespace

// Not inlined: the compiler would find std::free beside the standard's new.
__attribute__((noinline)) void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
__attribute__((noinline)) void operator delete(void* memory) noexcept { std::free(memory); }
__attribute__((noinline)) void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace bearing_calibration::core {
namespace {

using test::defaultDetector;
using test::kDefaultLightHeight_m;
using test::SpotDrawing;
using test::spotOfLight;

constexpr double kBackground = 20.0;
constexpr double kLight = 160.0;

cv::Mat exposeSpots(const DetectorConfig& config, const std::vector<SpotDrawing>& spots,
                    unsigned seed) {
  cv::Mat expected = test::flatImage(config.sensor.width_px, config.sensor.height_px, kBackground);
  for (const SpotDrawing& spot : spots) addSpot(&expected, spot);
  std::mt19937 random(seed);
  return test::expose(expected, config.sensor, &random);
}

SpotDrawing lightAt(const DetectorConfig& config, double distance_m, double azimuth_rad) {
  return spotOfLight(config, {distance_m, kDefaultLightHeight_m}, azimuth_rad, kLight);
}

/// The only rejection of an image, for a message of its name.
std::string onlyRejection(const DetectionResult& result) {
  if (!result.lights.empty()) return "accepted";
  if (result.rejected.size() != 1) return std::to_string(result.rejected.size()) + " rejected";
  return describe(result.rejected.front().rejection);
}

TEST(LightDetector, FindsTheLightAtEveryDistanceAndAzimuth) {
  for (int handedness : {1, -1}) {
    DetectorConfig config = defaultDetector();
    config.view.handedness = handedness;
    LightDetector detector(config);
    for (double distance : {0.5, 1.0, 5.0}) {
      for (double azimuth : {-3.0, -1.2, 0.1, 2.4}) {
        const DetectionResult& result =
            detector.detect(exposeSpots(config, {lightAt(config, distance, azimuth)}, 5));
        ASSERT_EQ(result.lights.size(), 1u) << onlyRejection(result) << " at " << distance << " m";
        const Bearing& bearing = result.lights.front().bearing;
        const double stddev = std::sqrt(bearing.azimuth_variance_rad2);
        EXPECT_NEAR(wrapAngle(bearing.azimuth_rad - azimuth), 0.0, 5.0 * stddev);
        const double radius = *radiusFromLight(config.mirror, {distance, kDefaultLightHeight_m});
        EXPECT_NEAR(bearing.image_radius_px, radius,
                    5.0 * std::sqrt(bearing.image_radius_variance_px2));
        EXPECT_NEAR(bearing.elevation_rad, elevationFromRadius(config.mirror, radius),
                    5.0 * std::sqrt(bearing.elevation_variance_rad2));
        EXPECT_GT(bearing.probability, 0.5);
        EXPECT_LE(bearing.probability, 1.0);
      }
    }
  }
}

// A core of half the diameter is full, which is a quarter of the area.
TEST(LightDetector, SaysHowMuchOfALightIsSaturated) {
  const DetectorConfig config = defaultDetector();
  const SpotDrawing spot = lightAt(config, 0.5, 0.3);
  SpotDrawing core = spot;
  core.major_diameter_px *= 0.5;
  core.minor_diameter_px *= 0.5;
  core.light_levels = 200.0;
  LightDetector detector(config);
  const DetectionResult& result = detector.detect(exposeSpots(config, {spot, core}, 7));
  ASSERT_EQ(result.lights.size(), 1u) << onlyRejection(result);
  EXPECT_NEAR(result.lights.front().ellipse.saturated_fraction, 0.25, 0.05);
}

TEST(LightDetector, SixteenBitsGiveTheSameBearing) {
  const DetectorConfig config = defaultDetector();
  const cv::Mat narrow = exposeSpots(config, {lightAt(config, 1.0, 0.3)}, 6);
  DetectorConfig wide_config = config;
  constexpr int kScale = 16;
  wide_config.sensor.electrons_per_level /= kScale;
  wide_config.sensor.saturation_level *= kScale;
  wide_config.threshold.min_contrast_levels *= kScale;
  cv::Mat wide;
  narrow.convertTo(wide, CV_16U, kScale);
  LightDetector narrow_detector(config);
  LightDetector wide_detector(wide_config);
  const DetectionResult& narrow_result = narrow_detector.detect(narrow);
  const DetectionResult& wide_result = wide_detector.detect(wide);
  ASSERT_EQ(narrow_result.lights.size(), 1u);
  ASSERT_EQ(wide_result.lights.size(), 1u) << onlyRejection(wide_result);
  EXPECT_NEAR(wide_result.lights.front().bearing.azimuth_rad,
              narrow_result.lights.front().bearing.azimuth_rad, 1e-9);
}

/// A rig that is known well: what is off by more than its optics explain is no light.
DetectorConfig knownOptics() {
  DetectorConfig config = defaultDetector();
  config.optics_stddev = {};
  return config;
}

TEST(LightDetector, SaysWhyASpotIsNotTheLight) {
  DetectorConfig config = knownOptics();
  config.light.max_height_m = 0.0;
  LightDetector detector(config);
  const SpotDrawing light = lightAt(config, 1.0, 0.7);
  const auto rejection = [&](const SpotDrawing& spot) {
    return onlyRejection(detector.detect(exposeSpots(config, {spot}, 7)));
  };
  EXPECT_EQ(rejection(light), "accepted");
  SpotDrawing spot = light;
  spot.major_diameter_px = spot.minor_diameter_px = 4.0;
  EXPECT_EQ(rejection(spot), "too few pixels");
  spot.major_diameter_px = spot.minor_diameter_px = 60.0;
  EXPECT_EQ(rejection(spot), "too many pixels");
  spot = light;
  spot.minor_diameter_px *= 1.5;
  EXPECT_EQ(rejection(spot), "wrong size along the azimuth");
  spot = light;
  spot.major_diameter_px *= 1.5;
  EXPECT_EQ(rejection(spot), "wrong size along the radius");
  spot = light;
  spot.major_angle_rad += radiansFromDegrees(20.0);
  EXPECT_EQ(rejection(spot), "axis off the radius");
  constexpr double kOverTheApex_m = 0.05;
  EXPECT_EQ(rejection(spotOfLight(config, {1.0, kOverTheApex_m}, 0.0, kLight)),
            "above the horizon");
}

TEST(LightDetector, ASpotBelowTheLeastQualityIsRefused) {
  DetectorConfig config = defaultDetector();
  const cv::Mat image = exposeSpots(config, {lightAt(config, 1.0, 0.7)}, 7);
  config.gates.min_probability = 1.0;  // nothing is certain
  LightDetector detector(config);
  EXPECT_EQ(onlyRejection(detector.detect(image)), "unlike a light");
}

/// A lamp's soft reflection: bright in the middle, of the size that a light would have.
TEST(LightDetector, ASpotThatIsNotEvenlyFilledIsRefused) {
  const DetectorConfig config = knownOptics();
  const SpotDrawing light = lightAt(config, 1.0, 0.7);
  cv::Mat expected = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
  for (const double part : {0.4, 0.7, 1.2}) {  // discs on each other, together as wide as one
    SpotDrawing disc = light;
    disc.major_diameter_px *= part;
    disc.minor_diameter_px *= part;
    disc.light_levels /= 3.0;
    addSpot(&expected, disc);
  }
  std::mt19937 random(9);
  LightDetector detector(config);
  EXPECT_EQ(onlyRejection(detector.detect(test::expose(expected, config.sensor, &random))),
            "not evenly filled");
}

TEST(LightDetector, ASpotCutByAPostOrByTheRowsIsRefused) {
  DetectorConfig config = defaultDetector();
  config.mask.posts = {{0.7 + radiansFromDegrees(4.0), radiansFromDegrees(3.0)}};
  const cv::Mat image = exposeSpots(config, {lightAt(config, 1.0, 0.7)}, 8);
  LightDetector behind_post(config);
  EXPECT_EQ(onlyRejection(behind_post.detect(image)), "cut by the mask");
  config.mask.posts.clear();
  config.mask.first_row = static_cast<int>(lightAt(config, 1.0, 0.7).centre_px.y()) - 4;
  LightDetector below_row(config);
  EXPECT_EQ(onlyRejection(below_row.detect(image)), "cut by the mask");
}

TEST(LightDetector, ACrossIsNoEllipse) {
  const DetectorConfig config = defaultDetector();
  cv::Mat image(config.sensor.height_px, config.sensor.width_px, CV_8UC1, cv::Scalar(20));
  image(cv::Rect(470, 237, 19, 5)).setTo(180);
  image(cv::Rect(477, 230, 5, 19)).setTo(180);
  LightDetector detector(config);
  EXPECT_EQ(onlyRejection(detector.detect(image)), "not an ellipse");
}

TEST(LightDetector, LooksInThePredictedRegionFirst) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  const cv::Mat image =
      exposeSpots(config, {lightAt(config, 1.0, 0.7), lightAt(config, 1.5, -2.0)}, 9);
  EXPECT_EQ(detector.detect(image).lights.size(), 2u);
  EXPECT_FALSE(detector.detect(image).in_region);
  const DetectionResult& result = detector.detect(image, SearchRegion{std::nullopt, {0.75, 0.2}});
  ASSERT_EQ(result.lights.size(), 1u);
  EXPECT_TRUE(result.in_region);
  EXPECT_NEAR(result.lights.front().bearing.azimuth_rad, 0.7, 0.01);
}

TEST(LightDetector, LooksEverywhereWhenTheRegionIsEmpty) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  const cv::Mat image = exposeSpots(config, {lightAt(config, 1.0, 0.7)}, 10);
  const DetectionResult& result = detector.detect(image, SearchRegion{std::nullopt, {-1.5, 0.2}});
  EXPECT_EQ(result.lights.size(), 1u);
  EXPECT_FALSE(result.in_region);
}

/// As a light of that place, but larger.
SpotDrawing doubtfulAt(const DetectorConfig& config, double azimuth_rad, double larger) {
  SpotDrawing spot = lightAt(config, 1.0, azimuth_rad);
  spot.major_diameter_px *= larger;
  spot.minor_diameter_px *= larger;
  return spot;
}

TEST(LightDetector, LooksEverywhereWhenTheRegionHasOnlyADoubtfulSpot) {
  const DetectorConfig config = defaultDetector();
  const SpotDrawing light = lightAt(config, 1.5, -2.0);
  const SpotDrawing doubtful = doubtfulAt(config, 0.7, 2.4);
  const cv::Mat image = exposeSpots(config, {doubtful, light}, 12);
  LightDetector detector(config);
  const SearchRegion around_doubtful{std::nullopt, {0.75, 1.5}};
  EXPECT_LT(detector.detect(exposeSpots(config, {doubtful}, 12)).lights.at(0).bearing.probability,
            LightDetector::kLikely);
  const DetectionResult& result = detector.detect(image, around_doubtful);
  EXPECT_FALSE(result.in_region);
  ASSERT_NE(likeliestLight(result.lights), nullptr);
  EXPECT_NEAR(likeliestLight(result.lights)->bearing.azimuth_rad, -2.0, 0.01);
}

// The lowest threshold takes in the rim of light around a bright spot, a higher one does not: which
// is tried must not depend on how little else is searched.
TEST(LightDetector, ABrightLightIsAsLikelyByItselfWhereItIsExpected) {
  const DetectorConfig config = test::defaultDetector();
  LightDetector detector(config);
  std::set<int> thresholds;
  for (double light_levels = 100.0; light_levels < 2000.0; light_levels *= 1.2) {
    cv::Mat image = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
    addSpot(&image,
            test::spotOfLight(config, {0.5, test::kDefaultLightHeight_m}, 0.7, light_levels));
    cv::GaussianBlur(image, image, {}, 1.3);
    image.convertTo(image, CV_8U);
    const auto logOddsOf = [&](const std::optional<SearchRegion>& region) {
      const DetectionResult& seen = detector.detect(image, region);
      EXPECT_EQ(seen.in_region, region.has_value());
      const double probability = seen.lights.at(0).bearing.probability;
      return std::log(seen.part_searched * probability / (1.0 - probability));
    };
    const double by_whole = logOddsOf(std::nullopt);
    thresholds.insert(detector.detect(image).threshold_levels);
    EXPECT_NEAR(logOddsOf(SearchRegion{std::nullopt, {0.7, 0.2}}), by_whole, 1e-4) << light_levels;
  }
  EXPECT_GT(thresholds.size(), 1U) << "no light needs a higher one: nothing is tested";
}

TEST(LightDetector, FindsALightThatTouchesAWindow) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  const SpotDrawing spot = lightAt(config, 1.0, 0.0);
  // The spot is 11 px wide across the radius, which is a row here; the window covers its border.
  for (int overlap_px : {0, 1}) {
    cv::Mat image = exposeSpots(config, {spot}, 15);
    const int last_row = static_cast<int>(spot.centre_px.y() - 5.5) + overlap_px;
    image(cv::Rect(cvRound(spot.centre_px.x()) - 40, last_row - 40, 80, 41)).setTo(255);
    const DetectionResult& result = detector.detect(image);
    ASSERT_EQ(result.lights.size(), 1u) << overlap_px;
    EXPECT_TRUE(result.opened);
    const Bearing& bearing = result.lights.front().bearing;
    EXPECT_LT(std::abs(bearing.azimuth_rad), 3.0 * std::sqrt(bearing.azimuth_variance_rad2));
    EXPECT_LT(std::abs(bearing.azimuth_rad), radiansFromDegrees(0.3));
  }
}

// Of a sharp lens: what an opening keeps is wider than its lights, though they are small.
TEST(LightDetector, FindsASmallLightBesideAWindow) {
  DetectorConfig config = defaultDetector();
  config.mirror.aperture_m = 0.2e-3;
  LightDetector detector(config);
  for (double distance_m : {0.5, 1.0, 3.0}) {
    const SpotDrawing spot = lightAt(config, distance_m, 0.0);
    cv::Mat image = exposeSpots(config, {spot}, 15);
    const int first_row = static_cast<int>(spot.centre_px.y() - 0.5 * spot.minor_diameter_px + 0.5);
    const int end_row = first_row - 1;  // a row lies between them
    image(cv::Rect(cvRound(spot.centre_px.x()) - 40, end_row - 41, 80, 41)).setTo(255);
    const DetectionResult& result = detector.detect(image);
    ASSERT_EQ(result.lights.size(), 1u) << distance_m << " m: " << onlyRejection(result);
    EXPECT_TRUE(result.opened);
    const Bearing& bearing = result.lights.front().bearing;
    EXPECT_LT(std::abs(bearing.azimuth_rad), 3.0 * std::sqrt(bearing.azimuth_variance_rad2));
    EXPECT_LT(std::abs(bearing.azimuth_rad), radiansFromDegrees(0.3));
  }
}

TEST(LightDetector, AWindowAloneIsRejectedAsItStandsInTheImage) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  cv::Mat image(config.sensor.height_px, config.sensor.width_px, CV_8UC1, cv::Scalar(20));
  image(cv::Rect(430, 200, 80, 41)).setTo(255);
  const DetectionResult& result = detector.detect(image);
  EXPECT_TRUE(result.lights.empty());
  EXPECT_FALSE(result.opened);
  EXPECT_EQ(onlyRejection(result), "too many pixels");
}

SearchRegion placeAt(double radius_px, double azimuth_rad) {
  return {ExpectedPlace{{radius_px, azimuth_rad}, 0.02, 5.0}, {azimuth_rad, 0.2}};
}

TEST(LightDetector, LooksWhereTheLightIsExpectedBeforeTheSector) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  // One behind the other, as far as the default mirror allows.
  const cv::Mat image =
      exposeSpots(config, {lightAt(config, 0.4, 0.7), lightAt(config, 3.0, 0.7)}, 13);
  EXPECT_EQ(detector.detect(image).lights.size(), 2u);
  for (double distance_m : {0.4, 3.0}) {
    const SpotDrawing spot = lightAt(config, distance_m, 0.7);
    const MirrorPixel seen =
        mirrorPixelFromImage(config.view, spot.centre_px.x(), spot.centre_px.y());
    const DetectionResult& result = detector.detect(image, placeAt(seen.image_radius_px, 0.71));
    ASSERT_EQ(result.lights.size(), 1u);
    EXPECT_TRUE(result.in_region);
    EXPECT_NEAR(result.lights.front().bearing.image_radius_px, seen.image_radius_px, 0.1);
    EXPECT_NEAR(result.lights.front().bearing.azimuth_rad, 0.7, 0.001);
  }
  EXPECT_EQ(detector.detect(image, placeAt(60.0, 0.71)).lights.size(), 2u);  // in the sector
  EXPECT_TRUE(detector.detect(image, placeAt(60.0, 0.71)).in_region);
  EXPECT_EQ(detector.detect(image, placeAt(60.0, -2.0)).lights.size(), 2u);  // anywhere
  EXPECT_FALSE(detector.detect(image, placeAt(60.0, -2.0)).in_region);
}

/// Whatever part of a light lies in the patch: it is measured whole, or not there.
TEST(LightDetector, APatchNeverCutsALight) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  const SpotDrawing spot = lightAt(config, 1.0, 0.7);
  const cv::Mat image = exposeSpots(config, {spot}, 14);
  const Bearing whole = detector.detect(image).lights.at(0).bearing;
  int found_in_place = 0;
  for (double off_px = -60.0; off_px <= 60.0; off_px += 1.0) {
    SearchRegion region = placeAt(whole.image_radius_px + off_px, 0.7);
    region.sector.centre_rad = -2.0;  // nothing there
    const DetectionResult& result = detector.detect(image, region);
    ASSERT_EQ(result.lights.size(), 1u) << off_px;
    EXPECT_NEAR(result.lights[0].bearing.azimuth_rad, whole.azimuth_rad, 1e-5) << off_px;
    EXPECT_NEAR(result.lights[0].bearing.image_radius_px, whole.image_radius_px, 1e-2) << off_px;
    found_in_place += result.in_region ? 1 : 0;
  }
  EXPECT_GE(found_in_place, 11);  // whose place it is
  EXPECT_LE(found_in_place, 60);
}

TEST(LightDetector, UniformImagesShowNothing) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  for (int level : {0, 128, 255}) {
    const cv::Mat image(config.sensor.height_px, config.sensor.width_px, CV_8UC1,
                        cv::Scalar(level));
    EXPECT_TRUE(detector.detect(image).lights.empty()) << "level " << level;
  }
}

TEST(LightDetector, SoftwareDefocusMakesAnEllipseOfASharpLight) {
  DetectorConfig config = defaultDetector();
  config.mirror.aperture_m = 0.1e-3;  // a pinhole: the light is about a pixel wide
  config.defocus_sigma_px = 3.0;
  config.threshold.min_contrast_levels = 4.0;
  LightDetector detector(config);
  constexpr double kAzimuth = 0.7;
  SpotDrawing sharp = lightAt(config, 1.0, kAzimuth);
  sharp.light_levels = 235.0;
  sharp.major_diameter_px = sharp.minor_diameter_px = 4.0;
  // The light itself may be some centimetres wide.
  const DetectionResult& result = detector.detect(exposeSpots(config, {sharp}, 11));
  ASSERT_EQ(result.lights.size(), 1u) << onlyRejection(result);
  const Detection& light = result.lights.front();
  const double expected_stddev = std::sqrt(9.0 + 1.0 + 1.0 / 12.0);
  EXPECT_NEAR(std::sqrt(light.ellipse.variances_px2()(1)), expected_stddev, 0.5);
  EXPECT_NEAR(light.bearing.azimuth_rad, kAzimuth,
              5.0 * std::sqrt(light.bearing.azimuth_variance_rad2));
}

TEST(LightDetector, WithoutTheMirrorsGatesManySmallLightsAreFound) {
  DetectorConfig config = defaultDetector();
  config.mirror_kind = MirrorKind::kOther;
  config.gates.min_pixels = 1;
  LightDetector detector(config);
  cv::Mat image(config.sensor.height_px, config.sensor.width_px, CV_8UC1, cv::Scalar(5));
  for (int i = 0; i < 12; ++i) image.at<std::uint8_t>(150 + 10 * (i % 4), 420 + 10 * (i / 4)) = 200;
  EXPECT_EQ(detector.detect(image).lights.size(), 12u);
}

/// With the shipped mirror's parameters, which are not used.
DetectorConfig withoutMirror() {
  DetectorConfig config = defaultDetector();
  config.mirror_kind = MirrorKind::kNone;
  config.camera = Camera{400.0, 400.0, 319.5, 239.5};
  config.view = {320.0, 240.0, 1};
  return config;
}

SpotDrawing discAt(double u_px, double v_px) {
  SpotDrawing spot;
  spot.centre_px = {u_px, v_px};
  spot.major_diameter_px = spot.minor_diameter_px = 12.0;
  spot.light_levels = 150.0;
  return spot;
}

TEST(LightDetector, WithoutAMirrorLightsAreFoundInTheWholeImage) {
  const DetectorConfig config = withoutMirror();
  LightDetector detector(config);
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(320.0, 240.0), Eigen::Vector2d(319.5, 239.5), Eigen::Vector2d(12.0, 12.0),
        Eigen::Vector2d(627.0, 467.0)}) {
    const DetectionResult& result =
        detector.detect(exposeSpots(config, {discAt(place.x(), place.y())}, 3));
    ASSERT_EQ(result.lights.size(), 1u) << place.transpose() << onlyRejection(result);
    const Bearing& bearing = result.lights.front().bearing;
    const double right = (place.x() - 319.5) / 400.0;
    const double up = -(place.y() - 239.5) / 400.0;
    EXPECT_NEAR(bearing.azimuth_rad, -std::atan(right),
                5.0 * std::sqrt(bearing.azimuth_variance_rad2));
    EXPECT_NEAR(bearing.elevation_rad, std::atan(up / std::hypot(1.0, right)),
                5.0 * std::sqrt(bearing.elevation_variance_rad2));
    EXPECT_LT(std::sqrt(bearing.azimuth_variance_rad2), 0.2 / 400.0) << "a fifth of a pixel";
    EXPECT_TRUE(std::isnan(bearing.image_radius_px));
  }
}

// A lamp with more pixels than gates/max_pixels is refused, and its brightest part found instead.
TEST(LightDetector, WithoutAMirrorAPartOfALampIsAsUncertainAsTheLampIsLarge) {
  const DetectorConfig config = withoutMirror();
  LightDetector detector(config);
  SpotDrawing lamp = discAt(400.0, 200.0);
  lamp.major_diameter_px = lamp.minor_diameter_px = 60.0;
  lamp.light_levels = 60.0;
  const DetectionResult& result =
      detector.detect(exposeSpots(config, {lamp, discAt(418.0, 190.0)}, 4));
  ASSERT_EQ(result.lights.size(), 1u);
  const Bearing& bearing = result.lights.front().bearing;
  const double off_rad = bearing.azimuth_rad + std::atan((400.0 - 319.5) / 400.0);
  EXPECT_GT(std::abs(off_rad), 10.0 / 400.0) << "that of the bright part";
  EXPECT_LT(std::abs(off_rad), 1.5 * std::sqrt(bearing.azimuth_variance_rad2));
}

TEST(LightDetector, WithoutAMirrorAxesAreThereAtAnyPlace) {
  const Eigen::Vector2d centre(320.0, 240.0);
  const Eigen::Matrix2d axes = mirrorAxes(centre, centre);
  EXPECT_TRUE((axes.transpose() * axes).isIdentity());
}

TEST(LightDetector, WithoutAMirrorNothingIsFoundBeyondTheLens) {
  DetectorConfig config = withoutMirror();
  config.camera->distortion[0] = -0.5;  // 0.544 * 400 px from the middle its images turn back
  LightDetector detector(config);
  EXPECT_EQ(detector.detect(exposeSpots(config, {discAt(319.5 + 200.0, 239.5)}, 3)).lights.size(),
            1u);
  EXPECT_EQ(onlyRejection(detector.detect(exposeSpots(config, {discAt(319.5 + 230.0, 239.5)}, 3))),
            describe(Rejection::kNoRay));
}

TEST(LightDetector, WithoutAMirrorNeedsItsCamera) {
  DetectorConfig config = withoutMirror();
  config.camera.reset();
  LightDetector detector(config);
  EXPECT_THROW(detector.detect(cv::Mat(480, 640, CV_8UC1, cv::Scalar(0))), std::invalid_argument);
}

TEST(LightDetector, WithoutAMirrorAnImageMayBeOfAnySize) {
  DetectorConfig config = withoutMirror();
  config.sensor.width_px = 80;  // far from the centre of a mirror that nobody has stated
  config.sensor.height_px = 60;
  config.mask.last_row = 59;
  EXPECT_EQ(errorsOf(config), std::vector<std::string>());
}

TEST(LightDetector, MeasuresNoMoreThanItsLimit) {
  DetectorConfig config = defaultDetector();
  config.mirror_kind = MirrorKind::kOther;
  config.gates.min_pixels = 1;
  config.max_candidates = 5;
  LightDetector detector(config);
  cv::Mat image(config.sensor.height_px, config.sensor.width_px, CV_8UC1, cv::Scalar(5));
  for (int i = 0; i < 12; ++i) image.at<std::uint8_t>(150 + 10 * (i % 4), 420 + 10 * (i / 4)) = 200;
  const DetectionResult& result = detector.detect(image);
  EXPECT_EQ(result.lights.size(), 5u);
  EXPECT_EQ(result.rejections[static_cast<std::size_t>(Rejection::kTooManySpots)], 7);
}

TEST(LightDetector, WrongImagesBreakTheContract) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  EXPECT_THROW(detector.detect(cv::Mat()), std::invalid_argument);
  EXPECT_THROW(detector.detect(cv::Mat(1, 1, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(detector.detect(cv::Mat(480, 640, CV_8UC3)), std::invalid_argument);
  EXPECT_NO_THROW(detector.detect(cv::Mat(480, 640, CV_16UC1, cv::Scalar(0))));
  DetectorConfig wide = config;
  wide.sensor.saturation_level = 4095.0;
  LightDetector wide_detector(wide);
  EXPECT_THROW(wide_detector.detect(cv::Mat(480, 640, CV_8UC1)), std::invalid_argument);
}

TEST(LightDetector, ALightMayBeAsLargeAsTheImage) {
  DetectorConfig config = defaultDetector();
  config.gates.max_pixels = config.sensor.width_px * config.sensor.height_px;
  EXPECT_TRUE(errorsOf(config).empty());
}

TEST(LightDetector, RefusesAConfigurationWithEveryError) {
  EXPECT_THROW(LightDetector(DetectorConfig{}), std::invalid_argument);
  DetectorConfig config = defaultDetector();
  EXPECT_TRUE(errorsOf(config).empty());
  config.view.handedness = 0;
  config.light.min_distance_m = 1e-3;  // inside of the mirror
  config.mask.last_row = 480;
  EXPECT_EQ(errorsOf(config).size(), 3u);
}

TEST(LightDetector, RefusesAMaskBesideTheImage) {
  DetectorConfig config = defaultDetector();
  config.view.centre_u_px = 639.0 + config.mask.outer_radius_px - 1.0;
  EXPECT_TRUE(errorsOf(config).empty());
  config.view.centre_u_px += 2.0;
  EXPECT_EQ(errorsOf(config).size(), 1u);
  config.view.centre_u_px = -config.mask.outer_radius_px - 1.0;
  EXPECT_EQ(errorsOf(config).size(), 1u);
}

TEST(LightDetector, AllocatesNothingOnceItIsWarm) {
  const DetectorConfig config = defaultDetector();
  LightDetector detector(config);
  const cv::Mat image =
      exposeSpots(config, {lightAt(config, 1.0, 0.7), lightAt(config, 1.5, -2.0)}, 12);
  detector.detect(image);
  detector.detect(image, SearchRegion{std::nullopt, {0.75, 0.2}});
  const std::size_t before = allocations;
  std::size_t lights = 0;
  for (int i = 0; i < 10; ++i) {
    lights += detector.detect(image).lights.size();
    lights += detector.detect(image, SearchRegion{std::nullopt, {0.75, 0.2}}).lights.size();
  }
  EXPECT_EQ(allocations, before);
  EXPECT_EQ(lights, 30u);
}

}  // namespace
}  // namespace bearing_calibration::core
