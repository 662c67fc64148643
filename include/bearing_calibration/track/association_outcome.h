#pragma once

#include <cstdint>
#include <functional>

#include "bearing_calibration/filter/cartesian_state.h"

namespace bearing_calibration::core {

/// What became of one image in a calibration: for reports, beside the estimate.
struct AssociationOutcome {
  enum class Kind : std::uint8_t {
    kNothingSeen,
    kTaken,      ///< fused, or collected before there is a filter
    kGated,      ///< outside the gate of the filter
    kAmbiguous,  ///< two candidates were about as likely
  };
  Kind kind = Kind::kNothingSeen;
  /// On the encoders' clock; the motion is since the image before. The bearing is that of the
  /// likeliest candidate; NaN where nothing was seen.
  Observation observation;
  bool lost_light = false;  ///< everything before this image was given up
};

using OutcomeObserver = std::function<void(const AssociationOutcome&)>;

}  // namespace bearing_calibration::core
