// Measures how many images a second the simulator renders on one core.
// Usage: render_rate [IMAGES]

#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "bearing_calibration/simulation/image_renderer.h"

namespace {

using bearing_calibration::core::ImageRenderer;
using bearing_calibration::core::Light;
using bearing_calibration::core::Pose2;
using bearing_calibration::core::RendererConfig;

constexpr int kDefaultImages = 200;
constexpr double kTurnPerImage_rad = 0.1;  // so that no two images are alike

}  // namespace

int main(int argc, char** argv) {
  const int images = argc > 1 ? std::atoi(argv[1]) : kDefaultImages;
  if (images <= 0) {
    std::fprintf(stderr, "usage: render_rate [IMAGES > 0]\n");
    return 2;
  }
  const RendererConfig config;
  ImageRenderer renderer(config, bearing_calibration::core::roomRadiance({}));
  Light light;
  light.height_m = config.reference_height_m;

  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  unsigned long checksum = 0;  // keeps the work from being optimised away
  for (int i = 0; i < images; ++i) {
    const Pose2 world_from_sensor{{config.reference_distance_m, 0.0}, i * kTurnPerImage_rad};
    const cv::Mat image =
        renderer.render({light}, {world_from_sensor}, static_cast<std::uint64_t>(i));
    checksum += image.at<std::uint8_t>(image.rows / 2, 0);
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  std::printf(
      "%d images of %dx%d with one light of %d rays: %.2f ms each, %.0f images/s (sum %lu)\n",
      images, config.rig.width_px, config.rig.height_px, config.rays_per_light,
      1e3 * seconds / images, images / seconds, checksum);
  return 0;
}
