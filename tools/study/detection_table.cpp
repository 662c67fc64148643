// How often the light is found among clutter, by this detector as it is shipped and by others on
// the same images, how often one is found where there is none, what the probabilities are worth,
// and, in each fifth scene, what those of tracks say on a drive:
//
//     detection_table [SCENES [FIRST_SEED [FOLDER FOR PICTURES OF WRONG ANSWERS]]]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/annotation.h"
#include "bearing_calibration/vision/light_detector.h"
#include "support/synthetic_spot.h"
#include "tools/study/random_scene.h"
#include "tools/study/scene_drive.h"
#include "tools/study/simple_blob.h"

namespace bearing_calibration::core {
namespace {

constexpr double kRight_rad = radiansFromDegrees(0.5);  // an answer so near the truth is right
constexpr double kPredicted_rad = radiansFromDegrees(10.0);
constexpr double kPredictedStddev_rad = 0.25 * kPredicted_rad;
constexpr double kTaken = 0.5;  // an answer of a lower probability is none

RandomSceneConfig sceneConfig() {
  RandomSceneConfig config;
  config.rendered.reference_distance_m = 1.0;
  config.rendered.reference_height_m = -0.03;
  config.lights = 2;
  config.light_radius_m = 0.004;
  return config;
}

struct Observation {
  cv::Mat image;
  LightDetector* detector = nullptr;
  double light_azimuth_rad = 0.0;
  double predicted_azimuth_rad = 0.0;
};

/// config/detection.yaml for this scene's rig, the mirror's holders masked with a degree more.
DetectorConfig detectorFor(const CameraRig& rig, const RandomScene& scene) {
  constexpr double kMaskMargin_rad = radiansFromDegrees(1.0);
  DetectorConfig config = test::shippedDetector();
  config.view = {rig.centre_px.x(), rig.centre_px.y(), rig.handedness};
  for (const MirrorHolder& holder : scene.holders) {
    config.mask.posts.push_back({holder.azimuth_rad, holder.half_width_rad + kMaskMargin_rad});
  }
  return config;
}

std::optional<double> azimuthOf(const DetectorConfig& config, const cv::Point2d& pixel) {
  const MirrorPixel seen = mirrorPixelFromImage(config.view, pixel.x, pixel.y);
  const bool in_mask = seen.image_radius_px >= config.mask.inner_radius_px &&
                       seen.image_radius_px <= config.mask.outer_radius_px;
  return in_mask ? std::optional<double>(seen.azimuth_rad) : std::nullopt;
}

using Answer = std::optional<double>;  ///< azimuth [rad]

Answer answerFrom(const Detection* light) {
  const bool taken = light != nullptr && light->bearing.probability >= kTaken;
  return taken ? Answer(light->bearing.azimuth_rad) : Answer();
}

Answer wholeImage(const Observation& scene) {
  return answerFrom(likeliestLight(scene.detector->detect(scene.image).lights));
}

/// Searches the predicted region; what the full scan finds elsewhere is no answer, as a filter with
/// that prediction would not take it. Of several it takes the one that fits the prediction best.
Answer prediction(const Observation& scene) {
  const DetectionResult& result = scene.detector->detect(
      scene.image, SearchRegion{std::nullopt, {scene.predicted_azimuth_rad, kPredicted_rad}});
  if (!result.in_region) return {};
  const Detection* best = nullptr;
  double most = 0.0;
  for (const Detection& light : result.lights) {
    const double off = wrapAngle(light.bearing.azimuth_rad - scene.predicted_azimuth_rad);
    const double weight =
        light.bearing.probability * std::exp(-0.5 * std::pow(off / kPredictedStddev_rad, 2));
    if (weight <= most) continue;
    most = weight;
    best = &light;
  }
  return answerFrom(best);
}

/// The largest contour of a threshold at half of the image's brightest level.
Answer largestContour(const Observation& scene) {
  const DetectorConfig& config = scene.detector->config();
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
Answer simpleBlob(const Observation& scene) {
  const DetectorConfig& config = scene.detector->config();
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
  Answer (*find)(const Observation&);
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

void drawWhatWasSeen(const std::string& folder, const char* kind, const Observation& scene,
                     std::uint64_t seed) {
  const DetectorConfig& config = scene.detector->config();
  cv::Mat picture = annotate(scene.image, scene.detector->detect(scene.image), config);
  const Eigen::Vector2d at =
      imageFromMirrorPixel(config.view, {horizonRadiusPx(config.mirror), scene.light_azimuth_rad});
  cv::line(picture, {cvRound(config.view.centre_u_px), cvRound(config.view.centre_v_px)},
           {cvRound(at.x()), cvRound(at.y())}, cv::Scalar(0, 255, 255));
  cv::imwrite(folder + "/" + kind + "_" + std::to_string(seed) + ".png", picture);
}

/// Of all candidates of a probability, how many are the light.
struct Bin {
  int candidates = 0;
  int right = 0;
  double said = 0.0;
};
using Reliability = std::array<Bin, 5>;

void addTo(Reliability* reliability, const Observation& scene, bool lit) {
  for (const Detection& light : scene.detector->detect(scene.image).lights) {
    const double probability = light.bearing.probability;
    const std::size_t last = reliability->size() - 1;
    Bin& bin = (*reliability)[std::min(
        last, static_cast<std::size_t>(probability * static_cast<double>(reliability->size())))];
    const double off = wrapAngle(light.bearing.azimuth_rad - scene.light_azimuth_rad);
    ++bin.candidates;
    bin.said += probability;
    bin.right += lit && std::abs(off) <= kRight_rad ? 1 : 0;
  }
}

void print(const std::vector<Row>& rows, const Reliability& reliability, int scenes,
           std::uint64_t first_seed) {
  std::printf(
      "| detector, %d scenes from seed %llu | right %% | wrong %% | none %% |\n|---|---|---|---|\n",
      scenes, static_cast<unsigned long long>(first_seed));
  for (const Row& row : rows) {
    const double percent = 100.0 / scenes;
    std::printf("| %s | %.1f | %.1f | %.1f |\n", row.name, percent * row.right, percent * row.wrong,
                percent * row.none);
  }
  std::printf("\n| candidates | said | right |\n|---|---|---|\n");
  for (const Bin& bin : reliability) {
    const double share = 1.0 / std::max(1, bin.candidates);
    std::printf("| %d | %.2f | %.2f |\n", bin.candidates, share * bin.said, share * bin.right);
  }
}

/// A scene with its first `lights` lights on all the rows of that number.
void look(const RandomScene& drawn, int lights, std::uint64_t seed, const std::string& folder,
          LightDetector* detector, std::vector<Row>* rows, Reliability* reliability) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> error(0.0, kPredictedStddev_rad);
  const std::vector<Light> shown(drawn.lights.begin(), drawn.lights.begin() + lights);
  const double azimuth_rad = drawn.light_azimuth_rad;
  const Observation scene{encode(drawn.renderer->render(shown, {}, seed), {}), detector,
                          azimuth_rad, azimuth_rad + error(random)};
  if (lights < 2) addTo(reliability, scene, lights == 1);
  for (Row& row : *rows) {
    if (row.lights != lights) continue;
    const Row before = row;
    // Without a light no answer is right.
    const double truth_rad = lights > 0 ? azimuth_rad : std::numeric_limits<double>::quiet_NaN();
    count(&row, row.find(scene), truth_rad);
    if (folder.empty() || row.find != wholeImage || row.right != before.right) continue;
    const bool wrong = row.wrong != before.wrong;
    if (wrong || lights > 0) {
      drawWhatWasSeen(folder, wrong ? "wrong" : "none", scene, seed);
    }
  }
}

int run(int scenes, std::uint64_t first_seed, const std::string& folder) {
  constexpr int kScenesPerDrive = 5;
  std::vector<Row> rows{{"the whole image", 1, wholeImage},
                        {"with a +-10 deg prediction", 1, prediction},
                        {"two like lights, with that prediction", 2, prediction},
                        {"no light, the whole image", 0, wholeImage},
                        {"threshold + findContours, largest", 1, largestContour},
                        {"SimpleBlobDetector", 1, simpleBlob}};
  Reliability reliability;
  SceneDrives drives;
  const RandomSceneConfig scene_config = sceneConfig();
  for (int i = 0; i < scenes; ++i) {
    const std::uint64_t seed = first_seed + static_cast<std::uint64_t>(i);
    const RandomScene scene = randomScene(scene_config, seed);
    LightDetector detector(detectorFor(scene_config.rendered.rig, scene));
    for (int lights : {0, 1, 2}) look(scene, lights, seed, folder, &detector, &rows, &reliability);
    if (i % kScenesPerDrive != 0) continue;
    for (std::size_t lights : {0U, 1U}) drives.drive(scene, lights, &detector);
  }
  print(rows, reliability, scenes, first_seed);
  drives.print();
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
