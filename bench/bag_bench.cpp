// A bag of images and ticks: only reading it, finding the light in each image, and what
// calibrate_bag does with it. In real time, for calibrate_bag reads on a thread of its own.
#include <bearing_calibration/WheelTicks.h>
#include <benchmark/benchmark.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>

#include "bearing_calibration/vision/light_bearings.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration_ros/conversions.h"
#include "bearing_calibration_ros/image_conversion.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "support/rendered_observations.h"
#include "tools/owner/bag_calibration.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration_ros {
namespace {

namespace core = bearing_calibration::core;

constexpr double kDuration_s = 60.0;  // 600 images, 6000 readings of the encoders
constexpr double kLightHeight_m = -0.03;

core::SimulatedCase nearLight() {
  core::SimulatedCase simulated = core::paperCase(1);
  simulated.robot.world_from_start = {{1.0, -0.5}, 0.5 * core::kPi};
  simulated.lights.front().height_m = kLightHeight_m;
  simulated.duration_s = kDuration_s;
  return simulated;
}

core::RendererConfig rig() {
  core::RendererConfig config = core::test::renderedRig();
  config.rays_per_light = 1 << 12;  // as the simulation node has it
  return config;
}

/// The bag in a file of its own, taken away at the end.
class RenderedBag {
 public:
  RenderedBag() {
    const int file = mkstemps(path_.data(), 4);
    if (file < 0) throw std::runtime_error("no temporary file " + path_);
    close(file);
    write();
  }
  ~RenderedBag() { std::remove(path_.c_str()); }
  RenderedBag(const RenderedBag&) = delete;
  RenderedBag& operator=(const RenderedBag&) = delete;

  const std::string& path() const { return path_; }

 private:
  void write() const;
  std::string path_ =
      std::filesystem::temp_directory_path() / "bearing_calibration_bench_XXXXXX.bag";
};

void RenderedBag::write() const {
  const core::SimulatedCase simulated = nearLight();
  const core::SimulatedRecord record = core::simulate(simulated).record;
  core::ImageRenderer renderer(rig(), core::test::plainWall);
  rosbag::Bag bag(path_, rosbag::bagmode::Write);
  for (const core::WheelCounts& counts : record.ticks) {
    bearing_calibration::WheelTicks ticks;
    ticks.header.stamp = rosFromStamp(counts.stamp);
    ticks.left = counts.left_ticks;
    ticks.right = counts.right_ticks;
    bag.write("wheel_ticks", ticks.header.stamp, ticks);
  }
  for (std::size_t i = 0; i < record.bearings.size(); ++i) {
    const cv::Mat rendered = renderer.render(
        simulated.lights, {record.world_from_base[i] * simulated.robot.base_from_sensor}, i);
    sensor_msgs::Image image;
    image.header.stamp = rosFromStamp(record.bearings[i].stamp);
    image.width = static_cast<std::uint32_t>(rendered.cols);
    image.height = static_cast<std::uint32_t>(rendered.rows);
    image.step = image.width;
    image.encoding = sensor_msgs::image_encodings::MONO8;
    image.data.assign(rendered.datastart, rendered.dataend);
    bag.write("image", image.header.stamp, image);
  }
}

const RenderedBag& bagOfImages() {
  static const RenderedBag bag;
  return bag;
}

using OnTicks = std::function<void(const bearing_calibration::WheelTicks&)>;
using OnImage = std::function<void(const sensor_msgs::ImageConstPtr&)>;

void readBag(const OnTicks& on_ticks, const OnImage& on_image) {
  const rosbag::Bag bag(bagOfImages().path());
  rosbag::View view(bag);
  for (const rosbag::MessageInstance& message : view) {
    if (const auto ticks = message.instantiate<bearing_calibration::WheelTicks>()) on_ticks(*ticks);
    if (const auto image = message.instantiate<sensor_msgs::Image>()) on_image(image);
  }
}

void readOnly(benchmark::State& state) {
  bagOfImages();
  for (auto _ : state) {
    readBag([](bearing_calibration::WheelTicks ticks) { benchmark::DoNotOptimize(ticks.left); },
            [](const sensor_msgs::ImageConstPtr& image) {
              benchmark::DoNotOptimize(image->data.data());
            });
  }
}
BENCHMARK(readOnly)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The light of each image as the calibration takes it.
class ImageToBearings {
 public:
  core::BearingSet operator()(const sensor_msgs::ImageConstPtr& image) {
    const core::DetectionResult& found = detector_.detect(converter_.convert(image));
    return core::bearingsFromLights(found.lights, {}, stampFromRos(image->header.stamp),
                                    static_cast<int>(image->height));
  }

 private:
  core::LightDetector detector_{core::test::detectorOf(rig())};
  GreyConverter converter_;
};

void readAndDetect(benchmark::State& state) {
  bagOfImages();
  ImageToBearings bearings_of;
  for (auto _ : state) {
    std::size_t found = 0;
    readBag([](bearing_calibration::WheelTicks ticks) { benchmark::DoNotOptimize(ticks.left); },
            [&](const sensor_msgs::ImageConstPtr& image) {
              found += bearings_of(image).candidates.size();
            });
    if (found == 0) state.SkipWithError("no light was found in any image");
  }
}
BENCHMARK(readAndDetect)->Unit(benchmark::kMillisecond)->UseRealTime();

void calibrateBag(benchmark::State& state) {
  const double ticks = nearLight().robot.encoders.drive.ticks_per_revolution;
  core::BagSetup setup =
      core::readBagSetup({packagedConfig("robots/simulated.yaml")},
                         {"wheels/ticks_per_revolution=" + std::to_string(ticks)}, {});
  setup.detection.detector = core::test::detectorOf(rig());
  const core::BagJob job{bagOfImages().path(), std::nullopt, "bench"};
  for (auto _ : state) {
    std::atomic<std::uint64_t> progress{0};
    const core::BagOutcome outcome = core::calibrateBag(job, setup, &progress);
    if (!outcome.result.cartesian_state) state.SkipWithError("the mount was not found");
  }
}
BENCHMARK(calibrateBag)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace bearing_calibration_ros

BENCHMARK_MAIN();
