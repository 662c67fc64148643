#include "tools/study/scene_drive.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration/vision/light_tracks.h"

namespace bearing_calibration::core {
namespace {

constexpr double kSpeed_mps = 0.1;
constexpr double kTurn_radps = 0.5;
constexpr double kRight_rad = radiansFromDegrees(0.5);
constexpr double kTaken = 0.5;

Pose2 poseOnArc(double time_s) {
  const double yaw_rad = kTurn_radps * time_s;
  const double radius_m = kSpeed_mps / kTurn_radps;
  return {{radius_m * std::sin(yaw_rad), radius_m * (1.0 - std::cos(yaw_rad))}, wrapAngle(yaw_rad)};
}

/// What config/detection.yaml lets candidates move between two images.
SearchConfig shippedSearch() {
  SearchConfig config;
  config.max_turn_rate_radps = 2.0;
  config.max_radius_rate_pxps = 100.0;
  return config;
}

}  // namespace

void SceneDrives::drive(const RandomScene& scene, std::size_t lights, LightDetector* detector) {
  const std::vector<Light> shown(scene.lights.begin(),
                                 scene.lights.begin() + static_cast<std::ptrdiff_t>(lights));
  LightTracks tracks(shippedSearch());
  Counts& counts = counts_.at(lights);
  ++counts.drives;
  std::size_t moment = 0;
  for (int image = 1; image <= kMoments.back(); ++image) {
    const double time_s = (image - 1) / kRate_hz;
    const Pose2 pose = poseOnArc(time_s);
    const cv::Mat seen = scene.renderer->render(shown, {pose}, static_cast<std::uint64_t>(image));
    BearingSet set = bearingsFromLights(detector->detect(encode(seen, {})).lights, ShutterConfig(),
                                        stampFromSeconds(1.0 + time_s), seen.rows);
    tracks.follow(1.0, std::nullopt, &set);
    if (image != kMoments.at(moment)) continue;
    const auto best = std::max_element(set.candidates.begin(), set.candidates.end(),
                                       [](const Bearing& left, const Bearing& right) {
                                         return left.track_probability < right.track_probability;
                                       });
    if (best != set.candidates.end() && best->track_probability >= kTaken) {
      const auto truth =
          shown.empty() ? std::nullopt : scene.renderer->truthOf(shown.front(), {pose});
      const bool is_light =
          truth && std::abs(wrapAngle(best->azimuth_rad - truth->azimuth_rad)) <= kRight_rad;
      ++(is_light ? counts.right : counts.wrong).at(moment);
    }
    ++moment;
  }
}

void SceneDrives::print() const {
  const auto percent = [](const Counts& counts, int count) {
    return 100.0 * count / std::max(1, counts.drives);
  };
  const auto& [dark, lit] = counts_;
  std::printf(
      "\n| images at %.0f Hz | no light, %d drives: a track %% | light, %d drives: right %% | "
      "wrong "
      "%% |\n|---|---|---|---|\n",
      kRate_hz, dark.drives, lit.drives);
  for (std::size_t i = 0; i < kMoments.size(); ++i) {
    std::printf("| %d | %.1f | %.1f | %.1f |\n", kMoments[i], percent(dark, dark.wrong[i]),
                percent(lit, lit.right[i]), percent(lit, lit.wrong[i]));
  }
}

}  // namespace bearing_calibration::core
