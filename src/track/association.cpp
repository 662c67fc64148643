#include "bearing_calibration/track/association.h"

#include <cmath>
#include <limits>

namespace bearing_calibration::core {
namespace {

/// A second candidate inside the gate makes a choice ambiguous unless it is at least this much less
/// likely: twice the log of a likelihood ratio of 100.
constexpr double kClearlyLessLikely = 9.2;

double minusTwiceLogLikelihood(const Innovation& innovation) {
  return innovation.nis() + std::log(innovation.variance);
}

}  // namespace

Association associate(const AzimuthPrediction& prediction, const std::vector<Bearing>& candidates,
                      double gate) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Association nearest;
  double best = kNone;
  double second_best = kNone;  // of those inside the gate
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Innovation innovation =
        prediction.innovationOf(candidates[i].azimuth_rad, candidates[i].azimuth_variance_rad2);
    const bool inside = innovation.nis() <= gate;
    const double cost = minusTwiceLogLikelihood(innovation);
    if (inside && cost < best) {
      second_best = best;
      best = cost;
      nearest = {Association::Kind::kFound, i, innovation};
    } else if (inside) {
      second_best = std::min(second_best, cost);
    } else if (nearest.kind == Association::Kind::kNothingSeen ||
               (nearest.kind == Association::Kind::kGated &&
                innovation.nis() < nearest.innovation.nis())) {
      nearest = {Association::Kind::kGated, i, innovation};
    }
  }
  if (nearest.kind == Association::Kind::kFound && second_best - best < kClearlyLessLikely) {
    nearest.kind = Association::Kind::kAmbiguous;
  }
  return nearest;
}

}  // namespace bearing_calibration::core
