#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "bearing_calibration/vision/image_advice.h"
#include "bearing_calibration/vision/light_detector.h"
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

  void add(const core::DetectionResult& result);
  std::uint64_t refused() const;
};

/// The last image's best light, for people.
struct LastObservation {
  bool has_light = false;
  core::LightEllipse ellipse;
  core::BackgroundLevel background;
  int threshold_levels = 0;
};
LastObservation lastObservationFrom(const core::DetectionResult& result);

/// How the newest images did, of which there may be less than one for each status.
struct ImagesOfLate {
  bool silent = true;  ///< there are none
  bool refused = false;
  std::optional<core::Advice> advice;
};

/// A warning when no images come, when they are refused, or with the advice on focus and exposure;
/// fine otherwise.
void fillDiagnostics(const DetectionCounts& counts, const ImagesOfLate& images,
                     const LastObservation& observation,
                     diagnostic_updater::DiagnosticStatusWrapper* status);

}  // namespace bearing_calibration_ros
