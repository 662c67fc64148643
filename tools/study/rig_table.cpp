// How often a light is found, and how well it is read, by a detector that is told what ships of a
// rig that is another one in one value:
//
//     rig_table [IMAGES PER ROW]

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_observations.h"
#include "support/synthetic_spot.h"
#include "tools/study/wrong_rigs.h"

namespace bearing_calibration::core {
namespace {

void look(const WrongRig& row, int images) {
  constexpr unsigned kSeed = 61;
  constexpr double kRight_rad = radiansFromDegrees(5.0);  // a wrong rig moves the bearing, too
  constexpr double kLightRadius_m = 0.004;
  DetectorConfig config = test::shippedDetector();
  LightDetector detector(config);
  ImageRenderer renderer(row.rendered, test::plainWall);
  test::BearingErrors errors;
  int likely = 0;
  int visible = 0;
  for (const test::Observation& observation : test::randomObservations(images, 1.0, kSeed)) {
    Light light = observation.light();
    light.height_m = row.light_height_m;
    light.radius_m = kLightRadius_m;
    const Pose2 pose = observation.worldFromSensor();
    const auto truth = renderer.truthOf(light, {pose, Eigen::Vector2d::Zero(), 0.0});
    if (!truth) continue;
    const MirrorPixel at = mirrorPixelFromImage(config.view, truth->pixel.x(), truth->pixel.y());
    // A spot that the configured mask or the image cuts is none.
    constexpr double kSpot_px = 16.0;
    const double inside = std::min({at.image_radius_px - config.mask.inner_radius_px,
                                    config.mask.outer_radius_px - at.image_radius_px,
                                    truth->pixel.y(), config.mask.last_row - truth->pixel.y()});
    if (inside < kSpot_px) continue;
    ++visible;
    const cv::Mat image = renderer.render({light}, {pose}, static_cast<std::uint64_t>(visible));
    const Detection* best = likeliestLight(detector.detect(image).lights);
    if (best == nullptr) continue;
    const double off = wrapAngle(best->bearing.azimuth_rad - truth->azimuth_rad);
    if (std::abs(off) > kRight_rad) continue;
    errors.add(best->bearing, truth->azimuth_rad);
    likely += best->bearing.probability >= LightDetector::kLikely ? 1 : 0;
  }
  std::printf("| %s | %d | %.1f | %.1f | %.3f | %.2f |\n", row.name.c_str(), visible,
              100.0 * errors.found / visible, 100.0 * likely / visible, errors.rmse_deg(),
              errors.nees());
  std::fflush(stdout);
}

int run(int images) {
  std::printf(
      "| wrong | visible | found %% | probability of 0.5 %% | RMSE [deg] | NEES "
      "|\n|---|---|---|---|---|---|\n");
  RendererConfig rendered = test::renderedRig();
  rendered.rays_per_light = 1 << 14;
  for (const WrongRig& row : wrongRigs(rendered)) look(row, images);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  constexpr int kDefaultImages = 200;
  const int images = argc > 1 ? std::atoi(argv[1]) : kDefaultImages;
  if (images < 1) {
    std::fprintf(stderr, "usage: rig_table [IMAGES PER ROW > 0]\n");
    return EXIT_FAILURE;
  }
  return bearing_calibration::core::run(images);
}
