// How often the light is found among clutter, by this detector and by others on the same images:
//
//     detection_table [SCENES [FIRST_SEED [FOLDER FOR PICTURES OF WRONG ANSWERS]]]

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/simulation/random_scene.h"
#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/synthetic_spot.h"
#include "tools/study/simple_blob.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRight_rad = 1.0 / kDegreesPerRadian;  // an answer so near the truth is right
constexpr double kPredicted_rad = 10.0 / kDegreesPerRadian;

RandomSceneConfig sceneConfig(int lights) {
  RandomSceneConfig config;
  config.rendered.reference_distance_m = 1.0;
  config.rendered.reference_height_m = -0.03;
  config.lights = lights;
  return config;
}

struct Observation {
  cv::Mat image;
  double light_azimuth_rad = 0.0;
};

/// config/detection.yaml for this scene's rig, the mirror's holders masked with a degree more.
DetectorConfig detectorFor(const CameraRig& rig, const RandomScene& scene) {
  constexpr double kMaskMargin_rad = radiansFromDegrees(1.0);
  DetectorConfig config = test::defaultDetector();
  config.view = {rig.centre_px.x(), rig.centre_px.y(), rig.handedness};
  for (const MirrorHolder& holder : scene.holders) {
    config.mask.posts.push_back({holder.azimuth_rad, holder.half_width_rad + kMaskMargin_rad});
  }
  config.threshold.min_contrast_levels = 12.0;
  return config;
}

std::optional<double> azimuthOf(const DetectorConfig& config, const cv::Point2d& pixel) {
  const MirrorPixel seen = mirrorPixelFromImage(config.view, pixel.x, pixel.y);
  const bool in_mask = seen.image_radius_px >= config.mask.inner_radius_px &&
                       seen.image_radius_px <= config.mask.outer_radius_px;
  return in_mask ? std::optional<double>(seen.azimuth_rad) : std::nullopt;
}

using Answer = std::optional<double>;  ///< azimuth [rad]

Answer likeliest(const DetectionResult& result) {
  const Detection* best = likeliestLight(result.lights);
  return best == nullptr ? Answer() : Answer(best->bearing.azimuth_rad);
}

Answer shapeGates(DetectorConfig config, const Observation& scene) {
  config.light.below_apex = false;
  return likeliest(LightDetector(config).detect(scene.image));
}

Answer horizonGate(DetectorConfig config, const Observation& scene) {
  return likeliest(LightDetector(config).detect(scene.image));
}

/// Searches the predicted region; what the full scan finds elsewhere is no answer, as a filter with
/// that prediction would not take it.
Answer prediction(DetectorConfig config, const Observation& scene) {
  LightDetector detector(config);
  const DetectionResult& result = detector.detect(
      scene.image, SearchRegion{std::nullopt, {scene.light_azimuth_rad, kPredicted_rad}});
  return result.in_region ? likeliest(result) : Answer();
}

/// The largest contour of a threshold at half of the image's brightest level.
Answer largestContour(DetectorConfig config, const Observation& scene) {
  double brightest = 0.0;
  cv::minMaxLoc(scene.image, nullptr, &brightest);
  cv::Mat bright;
  cv::threshold(scene.image, bright, 0.5 * brightest, 255.0, cv::THRESH_BINARY);
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(bright, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  double largest = 0.0;
  Answer answer;
  for (const auto& contour : contours) {
    const cv::Moments moments = cv::moments(contour);
    if (moments.m00 <= largest) continue;
    const Answer azimuth =
        azimuthOf(config, {moments.m10 / moments.m00, moments.m01 / moments.m00});
    if (!azimuth) continue;
    largest = moments.m00;
    answer = azimuth;
  }
  return answer;
}

/// OpenCV's blob detector; the blob of the best response, which is the largest here.
Answer simpleBlob(DetectorConfig config, const Observation& scene) {
  std::vector<cv::KeyPoint> found;
  cv::SimpleBlobDetector::create(simpleBlobParams(config))->detect(scene.image, found);
  float largest = 0.0F;
  Answer answer;
  for (const cv::KeyPoint& blob : found) {
    const Answer azimuth = azimuthOf(config, blob.pt);
    if (!azimuth || blob.size <= largest) continue;
    largest = blob.size;
    answer = azimuth;
  }
  return answer;
}

struct Row {
  const char* name;
  int lights;
  Answer (*find)(DetectorConfig, const Observation&);
  int right = 0;
  int wrong = 0;
  int none = 0;
};

void count(Row* row, const Answer& answer, double truth_rad) {
  if (!answer) {
    ++row->none;
  } else if (std::abs(wrapAngle(*answer - truth_rad)) <= kRight_rad) {
    ++row->right;
  } else {
    ++row->wrong;
  }
}

void drawWhatWasSeen(const std::string& folder, const char* kind, const DetectorConfig& config,
                     const Observation& scene, std::uint64_t seed) {
  LightDetector detector(config);
  cv::Mat picture = annotate(scene.image, detector.detect(scene.image), config);
  const Eigen::Vector2d at =
      imageFromMirrorPixel(config.view, {horizonRadiusPx(config.mirror), scene.light_azimuth_rad});
  cv::line(picture, {cvRound(config.view.centre_u_px), cvRound(config.view.centre_v_px)},
           {cvRound(at.x()), cvRound(at.y())}, cv::Scalar(0, 255, 255));
  cv::imwrite(folder + "/" + kind + "_" + std::to_string(seed) + ".png", picture);
}

int run(int scenes, std::uint64_t first_seed, const std::string& folder) {
  std::vector<Row> rows{{"shape gates only", 1, shapeGates},
                        {"with the horizon gate", 1, horizonGate},
                        {"with horizon and a +-10 deg prediction", 1, prediction},
                        {"two like lights, with that prediction", 2, prediction},
                        {"threshold + findContours, largest", 1, largestContour},
                        {"SimpleBlobDetector", 1, simpleBlob}};
  for (int lights : {1, 2}) {
    const RandomSceneConfig config_of_scenes = sceneConfig(lights);
    for (int i = 0; i < scenes; ++i) {
      const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
      const RandomScene rendered = randomScene(config_of_scenes, seed);
      const DetectorConfig config = detectorFor(config_of_scenes.rendered.rig, rendered);
      const Observation scene{encode(rendered.image, {}), rendered.light_azimuth_rad};
      for (Row& row : rows) {
        if (row.lights != lights) continue;
        const Row before = row;
        count(&row, row.find(config, scene), scene.light_azimuth_rad);
        if (folder.empty() || row.find != horizonGate || row.right != before.right) continue;
        drawWhatWasSeen(folder, row.wrong != before.wrong ? "wrong" : "none", config, scene, seed);
      }
    }
  }
  std::printf(
      "| detector, %d scenes from seed %llu | right %% | wrong %% | none %% |\n|---|---|---|---|\n",
      scenes, static_cast<unsigned long long>(first_seed));
  for (const Row& row : rows) {
    const double percent = 100.0 / scenes;
    std::printf("| %s | %.1f | %.1f | %.1f |\n", row.name, percent * row.right, percent * row.wrong,
                percent * row.none);
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 1000;
  const long long first_seed = argc > 2 ? std::atoll(argv[2]) : 1;
  if (scenes < 1 || first_seed < 0) {
    std::fprintf(stderr, "usage: detection_table [SCENES > 0 [FIRST_SEED [FOLDER]]]\n");
    return EXIT_FAILURE;
  }
  return bearing_calibration::core::run(scenes, static_cast<std::uint64_t>(first_seed),
                                        argc > 3 ? argv[3] : "");
}
