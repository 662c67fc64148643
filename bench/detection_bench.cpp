// Time of the light detector beside plain reads of the same image, one thread. What counts are the
// ratios within one run.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/default_rig.h"
#include "support/synthetic_spot.h"
#include "tools/simple_blob.h"

namespace bearing_calibration {
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

void regionOfInterest(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  LightDetector detector(config);
  const AzimuthSector region{kAzimuth_rad, radiansFromDegrees(10.0)};
  if (!detector.detect(image, region).in_region) state.SkipWithError("the light was not found");
  for (auto _ : state) benchmark::DoNotOptimize(detector.detect(image, region).lights.size());
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

/// The region's brightest level and nothing else, with the compiler's vector instructions: what no
/// detector that looks at every pixel of the region can undercut.
__attribute__((noinline, optimize("O3"))) std::uint8_t readIntervals(
    const cv::Mat& image, const std::vector<PixelInterval>& intervals) {
  std::uint8_t brightest = 0;
  for (const PixelInterval& interval : intervals) {
    const std::uint8_t* row = image.ptr<std::uint8_t>(interval.row);
    for (int u = interval.begin; u < interval.end; ++u) brightest = std::max(brightest, row[u]);
  }
  return brightest;
}

void readRegion(benchmark::State& state) {
  const DetectorConfig config = detectorOf(state);
  const cv::Mat image = sceneOf(config);
  std::vector<PixelInterval> intervals;
  AnnulusMask(config.mask, config.view, config.sensor)
      .clip({kAzimuth_rad, radiansFromDegrees(10.0)}, &intervals);
  for (auto _ : state) benchmark::DoNotOptimize(readIntervals(image, intervals));
}

void thresholdAndContours(benchmark::State& state) {
  const cv::Mat image = sceneOf(detectorOf(state));
  cv::Mat bright;
  std::vector<std::vector<cv::Point>> contours;
  for (auto _ : state) {
    cv::threshold(image, bright, kThreshold, 255, cv::THRESH_BINARY);
    cv::findContours(bright, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
    for (const auto& contour : contours) benchmark::DoNotOptimize(cv::moments(contour));
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
BENCHMARK(manyLights)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Arg(16)->Unit(benchmark::kMicrosecond);
BENCHMARK(readRegion)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(thresholdAndContours)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);
BENCHMARK(simpleBlob)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace bearing_calibration

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
