// Accuracy of a bearing against the focus distance of the lens and the software's defocus, on
// ray-traced images of a point light at 0.5 to 5 m:
//
//     focus_table [IMAGES PER ROW]

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_observations.h"

namespace bearing_calibration::core {
namespace {

/// The light of a point 1 m away that reaches the image [electrons].
double lightIn(ImageRenderer* renderer) {
  const test::Observation observation{1.0, 0.0, 1.0};
  double sum = 0.0;
  for (float electrons : renderer->expose({observation.light()}, {observation.worldFromSensor()})) {
    sum += static_cast<double>(electrons);
  }
  for (float electrons : renderer->expose({}, {observation.worldFromSensor()})) {
    sum -= static_cast<double>(electrons);
  }
  return sum;
}

enum class Exposure {
  kOwn,   ///< so that this lens' spot peaks at 180 of 255
  kSame,  ///< so that the spot of the lens focused at 0.06 m does: the same light for all
};

struct Row {
  double focus_m;
  double defocus_px;  ///< sigma of the software's blur
  Exposure exposure;
  double brightness;  ///< of the light, against that exposure
};

void printRow(const Row& row, int images) {
  RendererConfig rendered = test::renderedRig();
  ImageRenderer reference(rendered, test::plainWall);
  rendered.rig.focus_distance_m = row.focus_m;
  ImageRenderer renderer(rendered, test::plainWall);
  const double brightness =
      row.brightness *
      (row.exposure == Exposure::kOwn ? 1.0 : lightIn(&reference) / lightIn(&renderer));

  DetectorConfig config = test::detectorOf(rendered);
  config.defocus_sigma_px = row.defocus_px;
  config.threshold.min_contrast_levels = 12.0;  // as in config/detection.yaml
  LightDetector detector(config);
  test::BearingErrors errors;
  double bound = 0.0;
  constexpr int kBounds = 5;  // they are slow, and vary little
  constexpr unsigned kSeed = 41;
  const std::vector<test::Observation> observations =
      test::randomObservations(images, brightness, kSeed);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const cv::Mat image =
        renderer.render({observations[i].light()}, {observations[i].worldFromSensor()}, i);
    const DetectionResult& result = detector.detect(image);
    if (result.lights.size() == 1) {
      errors.add(result.lights.front().bearing, observations[i].azimuth_rad);
    }
    if (i < kBounds) bound += azimuthBound(&renderer, config.sensor, observations[i]) / kBounds;
  }
  std::printf("| %.3g | %.0f | %s | %.2g | %.1f | %.4f | %.4f | %.2f | %.2f |\n", row.focus_m,
              row.defocus_px, row.exposure == Exposure::kOwn ? "own" : "same", row.brightness,
              100.0 * errors.found / images, errors.rmse_deg(), errors.bias_deg(), errors.nees(),
              std::sqrt(errors.sum_square_rad2 / errors.found / bound));
  std::fflush(stdout);
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  using bearing_calibration::core::Exposure;
  using bearing_calibration::core::Row;
  const int images = argc > 1 ? std::atoi(argv[1]) : 300;
  if (images < 1) {
    std::fprintf(stderr, "usage: focus_table [IMAGES PER ROW > 0]\n");
    return EXIT_FAILURE;
  }
  std::printf(
      "| focus [m] | defocus [px] | exposure | brightness | found %% | RMSE [deg] "
      "| bias [deg] | NEES | RMSE / bound |\n|---|---|---|---|---|---|---|---|---|\n");
  constexpr double kFar_m = 1e6;
  constexpr double kBright = 5.0;
  for (const Row& row :
       {Row{0.06, 0.0, Exposure::kOwn, 1.0}, Row{0.12, 0.0, Exposure::kOwn, 1.0},
        Row{kFar_m, 0.0, Exposure::kOwn, 1.0}, Row{kFar_m, 2.0, Exposure::kOwn, 1.0},
        Row{kFar_m, 0.0, Exposure::kSame, 1.0}, Row{kFar_m, 2.0, Exposure::kSame, 1.0},
        Row{0.06, 0.0, Exposure::kSame, kBright}, Row{kFar_m, 0.0, Exposure::kSame, kBright},
        Row{kFar_m, 2.0, Exposure::kSame, kBright}}) {
    bearing_calibration::core::printRow(row, images);
  }
  return EXIT_SUCCESS;
}
