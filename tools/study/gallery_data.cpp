// What tools/study/gallery.py draws: gallery_data FOLDER [IMAGES PER POINT]
//
// focus_N.png and focus.csv    the same light seen through lenses of different focus
// clutter.png and clutter.csv  a scene with every spot that the detector looked at
// distance.csv                 errors of bearings against the light's distance

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/rendered_series.h"
#include "tools/common/command_line.h"
#include "tools/study/random_scene.h"

namespace bearing_calibration::core {
namespace {

namespace filesystem = std::filesystem;

constexpr double kMinContrast_levels = 12.0;  // as in config/detection.yaml
constexpr unsigned kSeed = 61;

void writeFocus(const filesystem::path& folder, int images) {
  constexpr double kFar_m = 1e6;
  constexpr int kHalfSide_px = 24;
  std::ofstream table(folder / "focus.csv");
  table << "image,focus_m,found,rmse_deg\n";
  int number = 0;
  for (double focus_m : {0.05, 0.06, 0.08, 0.12, 0.3, kFar_m}) {
    test::RenderedSeries series = test::renderedSeries("point");
    series.rendered.rig.focus_distance_m = focus_m;
    series.detector = test::detectorOf(series.rendered);
    series.detector.threshold.min_contrast_levels = kMinContrast_levels;
    const test::BearingErrors errors = test::errorsOf(series, images, kSeed);

    ImageRenderer renderer(series.rendered, test::plainWall);
    const test::Observation observation{1.0, radiansFromDegrees(35.0), 1.0};
    const cv::Mat image =
        renderer.render({observation.light()}, {observation.worldFromSensor()}, 1);
    const auto truth =
        renderer.truthOf(observation.light(), {observation.worldFromSensor(), {0.0, 0.0}, 0.0});
    const cv::Point middle(cvRound(truth->pixel.x()), cvRound(truth->pixel.y()));
    const cv::Point corner = middle - cv::Point(kHalfSide_px, kHalfSide_px);
    const std::string name = "focus_" + std::to_string(number++) + ".png";
    cv::imwrite((folder / name).string(),
                image(cv::Rect(corner, cv::Size(2 * kHalfSide_px + 1, 2 * kHalfSide_px + 1))));
    table << name << "," << focus_m << "," << static_cast<double>(errors.found) / images << ","
          << errors.rmse_deg() << "\n";
  }
}

DetectorConfig detectorOf(const RandomSceneConfig& config, const RandomScene& scene) {
  constexpr double kMaskMargin_rad = radiansFromDegrees(1.0);
  DetectorConfig detector = test::detectorOf(config.rendered);
  detector.threshold.min_contrast_levels = kMinContrast_levels;
  for (const MirrorHolder& holder : scene.holders) {
    detector.mask.posts.push_back({holder.azimuth_rad, holder.half_width_rad + kMaskMargin_rad});
  }
  return detector;
}

void writeSpot(const Detection& spot, std::ofstream* table) {
  const LightEllipse& ellipse = spot.ellipse;
  *table << ellipse.centre_px.x() << "," << ellipse.centre_px.y() << ","
         << std::sqrt(std::max(0.0, ellipse.variances_px2()(1))) << ","
         << std::sqrt(std::max(0.0, ellipse.variances_px2()(0))) << "," << ellipse.pixels << ","
         << describe(spot.rejection) << ","
         << (spot.accepted() ? degreesFromRadians(spot.bearing.azimuth_rad) : 0.0) << ","
         << (spot.accepted() ? spot.bearing.probability : 0.0) << "\n";
}

/// A scene with many kinds of rejected spots, and a reflection that passes the gates.
void writeClutter(const filesystem::path& folder) {
  constexpr std::uint64_t kScene = 103;
  RandomSceneConfig config;
  config.rendered = test::renderedRig();
  config.rendered.rays_per_light = RendererConfig().rays_per_light;
  const RandomScene scene = randomScene(config, kScene);
  const cv::Mat& image = scene.image;
  cv::imwrite((folder / "clutter.png").string(), image);
  const DetectorConfig detector_config = detectorOf(config, scene);
  LightDetector detector(detector_config);
  const DetectionResult& result = detector.detect(image);
  std::ofstream table(folder / "clutter.csv");
  table << "column_px,row_px,radial_stddev_px,tangential_stddev_px,pixels,rejection,azimuth_deg,"
           "probability\n";
  for (const Detection& light : result.lights) writeSpot(light, &table);
  for (const Detection& spot : result.rejected) writeSpot(spot, &table);
  std::ofstream mask(folder / "clutter_mask.csv");
  mask << "inner_px,outer_px,horizon_px,true_azimuth_deg,handedness,column_px,row_px\n"
       << detector_config.mask.inner_radius_px << "," << detector_config.mask.outer_radius_px << ","
       << horizonRadiusPx(detector_config.mirror) << ","
       << degreesFromRadians(scene.light_azimuth_rad) << "," << detector_config.view.handedness
       << "," << detector_config.view.centre_u_px << "," << detector_config.view.centre_v_px
       << "\n";
}

/// Errors at one distance, all around.
test::BearingErrors errorsAt(const test::RenderedSeries& series, double distance_m, int images) {
  return test::errorsOf(series, test::observationsAt(distance_m, images, series.brightness, kSeed));
}

void writeDistance(const filesystem::path& folder, int images) {
  std::ofstream table(folder / "distance.csv");
  table << "series,distance_m,rmse_deg,predicted_deg\n";
  for (const char* name : {"point", "saturated", "ring, 10 % unequal", "ring, 30 % unequal"}) {
    const test::RenderedSeries series = test::renderedSeries(name);
    for (double distance_m : {0.3, 0.5, 0.8, 1.2, 2.0, 3.2, 5.0}) {
      const test::BearingErrors errors = errorsAt(series, distance_m, images);
      table << "\"" << name << "\"," << distance_m << "," << errors.rmse_deg() << ","
            << errors.predicted_deg() << "\n";
    }
  }
}

int run(int argc, char** argv) {
  constexpr int kDefaultImages = 40;
  const int images = argc > 2 ? std::atoi(argv[2]) : kDefaultImages;
  if (argc < 2 || images < 1) {
    std::fprintf(stderr, "usage: gallery_data FOLDER [IMAGES PER POINT > 0]\n");
    return EXIT_FAILURE;
  }
  const std::filesystem::path folder(argv[1]);
  std::filesystem::create_directories(folder);
  writeFocus(folder, images);
  writeClutter(folder);
  writeDistance(folder, images);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "gallery_data", [&] { return bearing_calibration::core::run(argc, argv); });
}
