// Time of the light detector beside plain reads of the same image, one thread. What counts are the
// ratios within one run.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"
#include "tools/study/random_scene.h"
#include "tools/study/simple_blob.h"

namespace bearing_calibration::core {
namespace {

constexpr double kAzimuth_rad = 0.7;
constexpr int kThreshold = 60;  // for the comparisons: above the background, below the light

/// The default rig seen by a finer sensor: every length in pixels grows by `scale`.
DetectorConfig detectorAt(int scale, int width, int height) {
  DetectorConfig config = test::defaultDetector();
  config.mirror.pixel_pitch_m /= scale;
  config.sensor.width_px = width;
  config.sensor.height_px = height;
  config.view.centre_u_px = 0.5 * (width - 1);
  config.view.centre_v_px = 0.5 * (height - 1);
  config.mask.inner_radius_px *= scale;
  config.mask.outer_radius_px *= scale;
  config.mask.last_row = height - 1;
  config.gates.max_pixels *= scale * scale;
  return config;
}

/// 640x480 for 0, 1280x1024 for 1.
DetectorConfig detectorOf(const benchmark::State& state) {
  return state.range(0) == 0 ? detectorAt(1, 640, 480) : detectorAt(2, 1280, 1024);
}

/// Lights in one distance all around, the first at kAzimuth_rad.
cv::Mat sceneOf(const DetectorConfig& config, int lights = 1) {
  cv::Mat expected = test::flatImage(config.sensor.width_px, config.sensor.height_px, 20.0);
  for (int i = 0; i < lights; ++i) {
    addSpot(&expected, test::spotOfLight(config, {1.0, test::kDefaultLightHeight_m},
                                         kAzimuth_rad + 2.0 * kPi * i / lights, 160.0));
  }
  std::mt19937 random(1);
  return test::expose(expected, config.sensor, &random);
}

/// One pixel after the other, as a loop without vector instructions reads them.
__attribute__((noinline, optimize("no-tree-vectorize"))) std::uint64_t readEachPixel(
    const cv::Mat& image) {
  std::uint64_t sum = 0;
  for (int v = 0; v < image.rows; ++v) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(v);
    for (int u = 0; u < image.cols; ++u) sum += row[u];
  }
  return sum;
}

void plainRead(benchmark::State& state) {
  const cv::Mat image = sceneOf(detectorOf(state));
  for (auto _ : state) benchmark::DoNotOptimize(readEachPixel(image));
}

void countNonZero(benchmark::State& state) {
  const cv::Mat image = sceneOf(detectorOf(state));
  for (auto _ : state) benchmark::DoNotOptimize(cv::countNonZero(image));
}

void fullScan(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  LightDetector detector(config);
  if (detector.detect(image).lights.size() != 1) state.SkipWithError("the light was not found");
  for (auto _ : state) benchmark::DoNotOptimize(detector.detect(image).lights.size());
}

/// What a robot has that tracks its light (detection.md): a prediction good to 0.5 deg that is
/// 20 ms old, and the image radius from the image before, a tenth of a second ago.
SearchRegion trackedRegion(const DetectorConfig& config) {
  SearchConfig search;
  search.use = true;
  search.sigmas = 4.0;
  search.margin_rad = 0.15;
  search.max_age_s = 0.5;
  search.max_turn_rate_radps = 2.0;
  search.max_radius_rate_pxps = 100.0 * config.sensor.width_px / 640;
  const double radius_px = *radiusFromLight(config.mirror, {1.0, test::kDefaultLightHeight_m});
  const Stamp image = stampFromSeconds(10.0);
  const BearingPrediction prediction{image - durationFromSeconds(0.02), kAzimuth_rad,
                                     std::pow(radiansFromDegrees(0.5), 2)};
  const SeenRadius seen{image - durationFromSeconds(0.1), radius_px, 0.01};
  return *searchRegion(search, prediction, seen, image);
}

void detectIn(benchmark::State& state, const DetectorConfig& config, const SearchRegion& region) {
  const cv::Mat image = sceneOf(config);
  LightDetector detector(config);
  if (!detector.detect(image, region).in_region) state.SkipWithError("the light was not found");
  for (auto _ : state) benchmark::DoNotOptimize(detector.detect(image, region).lights.size());
}

void regionOfInterest(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  detectIn(state, config, trackedRegion(config));
}

/// The light's radius not known: the whole sector.
void sectorOfInterest(benchmark::State& state) {
  detectIn(state, detectorOf(state), {std::nullopt, {kAzimuth_rad, radiansFromDegrees(10.0)}});
}

/// 640x480 with `range(0)` lights.
void manyLights(benchmark::State& state) {
  const auto lights = static_cast<std::size_t>(state.range(0));
  const DetectorConfig config = detectorAt(1, 640, 480);
  const cv::Mat image = sceneOf(config, static_cast<int>(lights));
  LightDetector detector(config);
  if (detector.detect(image).lights.size() != lights) state.SkipWithError("not all were found");
  for (auto _ : state) benchmark::DoNotOptimize(detector.detect(image).lights.size());
}

/// The patch's brightest level and nothing else, with the compiler's vector instructions.
__attribute__((noinline, optimize("O3"))) std::uint8_t brightestOf(const cv::Mat& patch) {
  std::uint8_t brightest = 0;
  for (int v = 0; v < patch.rows; ++v) {
    const std::uint8_t* row = patch.ptr<std::uint8_t>(v);
    for (int u = 0; u < patch.cols; ++u) brightest = std::max(brightest, row[u]);
  }
  return brightest;
}

/// What finding a light in a patch costs at the least: a look at each of its pixels. As many as the
/// region of interest has.
void readPatch(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  const int side = 64 * config.sensor.width_px / 640;
  const Detection light = LightDetector(config).detect(image).lights.at(0);
  const cv::Mat patch =
      image(cv::Rect(cvRound(light.ellipse.centre_px.x()) - side / 2,
                     cvRound(light.ellipse.centre_px.y()) - side / 2, side, side));
  for (auto _ : state) benchmark::DoNotOptimize(brightestOf(patch));
}

/// What measuring a light costs that is found already: background, centre and the sums of its
/// variance.
void spotAlone(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  const Detection light = LightDetector(config).detect(image).lights.at(0);
  const LightEllipse& ellipse = light.ellipse;
  const Eigen::Matrix2d axes = mirrorAxes(ellipse.centre_px, config.view.centre_px());
  const SpotWindow window{
      {ellipse.centre_px, axes * ellipse.variances_px2().asDiagonal() * axes.transpose(), 2.5},
      true};
  Search search;
  search.threshold_levels = kThreshold;
  search.background_levels = ellipse.background_levels;
  const SearchedImage searched{image, image};
  if (!measureSpot(searched, ellipse, window, search, config)) {
    state.SkipWithError("the light was not measured");
  }
  for (auto _ : state) {
    benchmark::DoNotOptimize(measureSpot(searched, ellipse, window, search, config));
  }
}

/// A light among windows, lamps, reflections and texture, ray-traced (detection.md).
struct ClutteredScene {
  ClutteredScene(const benchmark::State& state, std::uint64_t seed) : config(detectorOf(state)) {
    constexpr double kMaskMargin_rad = radiansFromDegrees(1.0);
    RandomSceneConfig scene;
    CameraRig& rig = scene.rendered.rig;
    rig.pixel_m *= static_cast<double>(rig.width_px) / config.sensor.width_px;
    rig.width_px = config.sensor.width_px;
    rig.height_px = config.sensor.height_px;
    rig.centre_px = {config.view.centre_u_px, config.view.centre_v_px};
    scene.rendered.reference_distance_m = 1.0;
    scene.rendered.reference_height_m = test::kDefaultLightHeight_m;
    config.view.handedness = rig.handedness;
    const RandomScene drawn = randomScene(scene, seed);
    for (const MirrorHolder& holder : drawn.holders) {
      config.mask.posts.push_back({holder.azimuth_rad, holder.half_width_rad + kMaskMargin_rad});
    }
    config.threshold.min_contrast_levels = 12.0;
    image = encode(drawn.image, {});
  }

  DetectorConfig config;
  cv::Mat image;
};

/// The first eight of detection.md's scenes, or the same scenes on the finer sensor; drawn
/// once.
const std::vector<ClutteredScene>& clutteredScenes(const benchmark::State& state) {
  constexpr std::uint64_t kScenes = 8;
  static std::map<std::int64_t, std::vector<ClutteredScene>> drawn;
  std::vector<ClutteredScene>& scenes = drawn[state.range(0)];
  for (std::uint64_t seed = scenes.size() + 1; seed <= kScenes; ++seed) {
    scenes.emplace_back(state, seed);
  }
  return scenes;
}

void clutteredScan(benchmark::State& state) {
  const std::vector<ClutteredScene>& scenes = clutteredScenes(state);
  std::vector<LightDetector> detectors;
  for (const ClutteredScene& scene : scenes) detectors.emplace_back(scene.config);
  for (auto _ : state) {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      benchmark::DoNotOptimize(detectors[i].detect(scenes[i].image).lights.size());
    }
  }
}

void findContours(const cv::Mat& image, cv::Mat* bright,
                  std::vector<std::vector<cv::Point>>* contours) {
  cv::threshold(image, *bright, kThreshold, 255, cv::THRESH_BINARY);
  cv::findContours(*bright, *contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  for (const auto& contour : *contours) benchmark::DoNotOptimize(cv::moments(contour));
}

void thresholdAndContours(benchmark::State& state) {
  const cv::Mat image = sceneOf(detectorOf(state));
  cv::Mat bright;
  std::vector<std::vector<cv::Point>> contours;
  for (auto _ : state) findContours(image, &bright, &contours);
}

void clutteredContours(benchmark::State& state) {
  const std::vector<ClutteredScene>& scenes = clutteredScenes(state);
  cv::Mat bright;
  std::vector<std::vector<cv::Point>> contours;
  for (auto _ : state) {
    for (const ClutteredScene& scene : scenes) findContours(scene.image, &bright, &contours);
  }
}

void simpleBlob(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  const auto detector = cv::SimpleBlobDetector::create(simpleBlobParams(config));
  std::vector<cv::KeyPoint> found;
  detector->detect(image, found);
  if (found.size() != 1) state.SkipWithError("the light was not found");
  for (auto _ : state) detector->detect(image, found);
}

BENCHMARK(plainRead)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(countNonZero)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(fullScan)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(regionOfInterest)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(sectorOfInterest)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(manyLights)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Arg(16)->Unit(benchmark::kMicrosecond);
BENCHMARK(readPatch)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(spotAlone)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(thresholdAndContours)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(clutteredScan)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(clutteredContours)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(simpleBlob)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
