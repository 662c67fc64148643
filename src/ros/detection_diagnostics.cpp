#include "bearing_calibration_ros/detection_diagnostics.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <cmath>

namespace bearing_calibration_ros {
namespace {

using Status = diagnostic_msgs::DiagnosticStatus;

double widthOf(double variance_px2) { return 4.0 * std::sqrt(std::max(0.0, variance_px2)); }

/// A light may be out of view or off for good reason: all else calls for a hand.
bool isWarning(const core::Advice& advice) {
  return advice.kind != core::AdviceKind::kNothingBright;
}

std::string warningOf(const ImagesOfLate& images) {
  if (images.silent) return "no images";
  if (images.refused) return "images are refused";
  return images.advice && isWarning(*images.advice) ? images.advice->sentence : std::string();
}

}  // namespace

void DetectionCounts::add(const core::DetectionResult& result) {
  ++images_used;
  images_with_light += result.lights.empty() ? 0 : 1;
  found_in_region += result.in_region ? 1 : 0;
  too_cluttered += result.too_cluttered ? 1 : 0;
  for (std::size_t i = 0; i < spots_rejected.size(); ++i) {
    spots_rejected[i] += static_cast<std::uint64_t>(result.rejections[i]);
  }
}

std::uint64_t DetectionCounts::refused() const {
  std::uint64_t sum = 0;
  for (const auto& [kind, count] : images_refused) sum += count;
  return sum;
}

LastObservation lastObservationFrom(const core::DetectionResult& result) {
  LastObservation observation;
  observation.background = result.background;
  observation.threshold_levels = result.threshold_levels;
  const core::Detection* best = core::likeliestLight(result.lights);
  observation.has_light = best != nullptr;
  if (observation.has_light) observation.ellipse = best->ellipse;
  return observation;
}

void fillDiagnostics(const DetectionCounts& counts, const ImagesOfLate& images,
                     const LastObservation& observation,
                     diagnostic_updater::DiagnosticStatusWrapper* status) {
  const std::string warning = warningOf(images);
  const std::string state = observation.has_light ? "light in view" : "no light in view";
  if (warning.empty()) {
    status->summary(Status::OK, state);
  } else {
    status->summary(Status::WARN, warning);
  }
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
  if (!observation.has_light) return;
  status->add("light's peak (levels)", observation.ellipse.peak_levels);
  status->add("light's saturated part", observation.ellipse.saturated_fraction);
  const Eigen::Vector2d variances_px2 = observation.ellipse.variances_px2();
  status->add("light's width along the azimuth (px)", widthOf(variances_px2(0)));
  status->add("light's width along the radius (px)", widthOf(variances_px2(1)));
}

}  // namespace bearing_calibration_ros
