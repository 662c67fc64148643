#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <cstdint>
#include <optional>
#include <string>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/guarded_nodelet.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// What the detection saw in an image, added to what it has seen since its start.
inline void addTo(Counts* counts, const core::DetectionResult& result) {
  ++(*counts)["images used"];
  (*counts)["images with a light"] += result.lights.empty() ? 0 : 1;
  (*counts)["images searched in the predicted region only"] += result.in_region ? 1 : 0;
  (*counts)["images given up as too cluttered"] += result.too_cluttered ? 1 : 0;
  for (std::size_t i = 0; i < result.rejections.size(); ++i) {
    if (result.rejections[i] == 0) continue;
    (*counts)[std::string("spots rejected: ") + core::describe(static_cast<core::Rejection>(i))] +=
        static_cast<std::uint64_t>(result.rejections[i]);
  }
}

/// How the newest images did, of which there may be less than one for each status.
struct ImagesOfLate {
  bool silent = true;  ///< there are none
  bool refused = false;
  std::optional<core::Advice> advice;
  std::optional<core::LightEllipse> light;  ///< the likeliest one of the last image
  core::BackgroundLevel background;         ///< of that image, too
  int threshold_levels = 0;

  void see(const core::DetectionResult& result) {
    const core::Detection* best = core::likeliestLight(result.lights);
    light = best == nullptr ? std::nullopt : std::optional(best->ellipse);
    background = result.background;
    threshold_levels = result.threshold_levels;
  }
  /// What calls for a hand; empty when nothing does. A light may be out of view or off for good
  /// reason.
  std::string warning() const {
    if (silent) return "no images";
    if (refused) return "images are refused";
    const bool is_one = advice && advice->kind != core::AdviceKind::kNothingBright;
    return is_one ? advice->sentence : std::string();
  }
};

/// A warning when no images come, when they are refused, or with the advice on focus and exposure;
/// fine otherwise.
inline void fillDiagnostics(const Counts& counts, const ImagesOfLate& images,
                            diagnostic_updater::DiagnosticStatusWrapper* status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  const std::string warning = images.warning();
  const std::string state = images.light ? "light in view" : "no light in view";
  status->summary(warning.empty() ? Status::OK : Status::WARN, warning.empty() ? state : warning);
  for (const auto& [what, count] : counts) status->add(what, count);
  status->add("advice", images.advice ? images.advice->sentence : "none");
  status->add("background (levels)", images.background.median);
  status->add("threshold (levels)", images.threshold_levels);
  if (!images.light) return;
  const Eigen::Vector2d width_px = 4.0 * images.light->variances_px2().cwiseSqrt();
  status->add("light's peak (levels)", images.light->peak_levels);
  status->add("light's saturated part", images.light->saturated_fraction);
  status->add("light's width along the azimuth (px)", width_px(0));
  status->add("light's width along the radius (px)", width_px(1));
}

/// Each value of lens and mirror as it is known now, by its parameter's name.
inline void fillOptics(const core::OpticsLearner& learner,
                       diagnostic_updater::DiagnosticStatusWrapper* status) {
  for (const core::LearntOptics& each : learner.optics()) {
    status->add(each.parameter, core::formatted("%s: %.6g (%s %.2g)", core::nameOf(each.state),
                                                each.value, each.stddev_parameter, each.stddev));
  }
}

}  // namespace bearing_calibration_ros
