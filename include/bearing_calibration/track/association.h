#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Which of an image's candidates is the light.
struct Association {
  enum class Kind : std::uint8_t {
    kNothingSeen,  ///< no candidate
    kGated,        ///< none inside the gate
    kAmbiguous,    ///< two that could be the light about equally well
    kFound,
  };
  Kind kind = Kind::kNothingSeen;
  std::size_t candidate = 0;        ///< kFound: its position in the list
  Innovation innovation{0.0, 0.0};  ///< of the nearest candidate, unless nothing was seen
};

/// The candidate nearest to the prediction by its NIS, when it passes the gate and no other is
/// nearly as likely.
/// @param gate  largest NIS that passes
Association associate(const AzimuthPrediction& prediction, const std::vector<Bearing>& candidates,
                      double gate);

/// How an image's light updates a filter.
struct FusionConfig {
  double gate = 0.0;      ///< largest NIS that passes
  double widening = 1.0;  ///< of the bearings' variances, for their correlation

  Bearing widened(Bearing light) const {
    light.azimuth_variance_rad2 *= widening;
    return light;
  }
};

}  // namespace bearing_calibration::core
