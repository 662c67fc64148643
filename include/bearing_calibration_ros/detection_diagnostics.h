#pragma once

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration/vision/light_detector.h"
#include "bearing_calibration/vision/optics_learner.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// What the detection nodelet has seen since its start, for people.
struct DetectionCounts {
  std::uint64_t images_used = 0;
  std::uint64_t images_dropped = 0;  ///< newer ones had come before their turn
  std::uint64_t images_with_light = 0;
  std::uint64_t found_in_region = 0;
  std::uint64_t too_cluttered = 0;
  std::map<std::string, std::uint64_t> images_refused;  ///< by kind
  std::array<std::uint64_t, core::kRejections> spots_rejected{};

  void add(const core::DetectionResult& result) {
    ++images_used;
    images_with_light += result.lights.empty() ? 0 : 1;
    found_in_region += result.in_region ? 1 : 0;
    too_cluttered += result.too_cluttered ? 1 : 0;
    for (std::size_t i = 0; i < spots_rejected.size(); ++i) {
      spots_rejected[i] += static_cast<std::uint64_t>(result.rejections[i]);
    }
  }
  std::uint64_t refused() const {
    std::uint64_t sum = 0;
    for (const auto& [kind, count] : images_refused) sum += count;
    return sum;
  }
};

/// The last image, for people.
struct LastObservation {
  std::optional<core::LightEllipse> light;  ///< the likeliest one
  core::BackgroundLevel background;
  int threshold_levels = 0;

  static LastObservation of(const core::DetectionResult& result) {
    const core::Detection* best = core::likeliestLight(result.lights);
    return {best == nullptr ? std::nullopt : std::optional(best->ellipse), result.background,
            result.threshold_levels};
  }
};

/// How the newest images did, of which there may be less than one for each status.
struct ImagesOfLate {
  bool silent = true;  ///< there are none
  bool refused = false;
  std::optional<core::Advice> advice;

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
inline void fillDiagnostics(const DetectionCounts& counts, const ImagesOfLate& images,
                            const LastObservation& observation,
                            diagnostic_updater::DiagnosticStatusWrapper* status) {
  using Status = diagnostic_msgs::DiagnosticStatus;
  const std::string warning = images.warning();
  const std::string state = observation.light ? "light in view" : "no light in view";
  status->summary(warning.empty() ? Status::OK : Status::WARN, warning.empty() ? state : warning);
  status->add("images used", counts.images_used);
  status->add("images dropped for newer ones", counts.images_dropped);
  status->add("images with a light", counts.images_with_light);
  status->add("images searched in the predicted region only", counts.found_in_region);
  status->add("images given up as too cluttered", counts.too_cluttered);
  for (const auto& [kind, count] : counts.images_refused) {
    status->add("images refused: " + kind, count);
  }
  for (std::size_t i = 0; i < counts.spots_rejected.size(); ++i) {
    if (counts.spots_rejected[i] == 0) continue;
    status->add(std::string("spots rejected: ") + core::describe(static_cast<core::Rejection>(i)),
                counts.spots_rejected[i]);
  }
  status->add("advice", images.advice ? images.advice->sentence : "none");
  status->add("background (levels)", observation.background.median);
  status->add("threshold (levels)", observation.threshold_levels);
  if (!observation.light) return;
  const auto width = [](double variance_px2) { return 4.0 * std::sqrt(variance_px2); };
  status->add("light's peak (levels)", observation.light->peak_levels);
  status->add("light's saturated part", observation.light->saturated_fraction);
  const Eigen::Vector2d variances_px2 = observation.light->variances_px2();
  status->add("light's width along the azimuth (px)", width(variances_px2(0)));
  status->add("light's width along the radius (px)", width(variances_px2(1)));
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
