#include "bearing_calibration/track/association.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

/// A second candidate inside the gate makes a choice ambiguous unless it is at least this much less
/// likely: twice the log of a likelihood ratio of 100.
constexpr double kClearlyLessLikely = 9.2;

double minusTwiceLogLikelihood(const Innovation& innovation) {
  return innovation.nis() + std::log(innovation.variance);
}

/// A wheel that spins for half a second turns the base by less.
constexpr double kLargestTurn_rad = 0.6;
/// Of what a light is off beside the turn: the base has slid by centimetres, too.
constexpr double kTurnTolerance_rad = 0.06;

struct Match {
  std::size_t lights = 0;  ///< each with a candidate of its own
  double turn_rad = 0.0;   ///< mean of theirs
};

/// Lights that are seen near where they would be after such a turn.
Match matchAfter(double turn_rad, const std::vector<AzimuthPrediction>& expected,
                 const std::vector<Bearing>& candidates) {
  Match match;
  std::vector<bool> is_taken(candidates.size(), false);
  for (const AzimuthPrediction& light : expected) {
    std::size_t nearest = candidates.size();
    double nearest_off_rad = kTurnTolerance_rad;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const double off_rad = wrapAngle(light.azimuth_rad - candidates[i].azimuth_rad - turn_rad);
      if (is_taken[i] || std::abs(off_rad) >= std::abs(nearest_off_rad)) continue;
      nearest = i;
      nearest_off_rad = off_rad;
    }
    if (nearest == candidates.size()) continue;
    is_taken[nearest] = true;
    ++match.lights;
    match.turn_rad += (turn_rad + nearest_off_rad - match.turn_rad) / match.lights;
  }
  return match;
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

bool isWhereExpected(const AzimuthPrediction& light, const Bearing& candidate) {
  constexpr double kUsualNis = 16.0;
  return light.innovationOf(candidate.azimuth_rad, candidate.azimuth_variance_rad2).nis() <=
         kUsualNis;
}

std::optional<double> hiddenTurn(const std::vector<AzimuthPrediction>& expected,
                                 const std::vector<Bearing>& candidates) {
  constexpr std::size_t kMany = 4;  // one of so many may be hidden
  const std::size_t needed = expected.size() - (expected.size() < kMany ? 0 : 1);
  if (needed < 2 || candidates.size() < needed) return std::nullopt;
  const auto usual =
      std::count_if(expected.begin(), expected.end(), [&](const AzimuthPrediction& light) {
        return std::any_of(candidates.begin(), candidates.end(), [&](const Bearing& candidate) {
          return isWhereExpected(light, candidate);
        });
      });
  if (2 * static_cast<std::size_t>(usual) >= expected.size()) return std::nullopt;
  std::optional<double> turn_rad;
  for (const AzimuthPrediction& light : expected) {
    for (const Bearing& candidate : candidates) {
      const double supposed_rad = wrapAngle(light.azimuth_rad - candidate.azimuth_rad);
      if (std::abs(supposed_rad) > kLargestTurn_rad) continue;
      const Match match = matchAfter(supposed_rad, expected, candidates);
      if (match.lights < needed) continue;
      const bool is_another =
          turn_rad && std::abs(wrapAngle(match.turn_rad - *turn_rad)) > kTurnTolerance_rad;
      if (is_another) return std::nullopt;
      turn_rad = match.turn_rad;
    }
  }
  return turn_rad;
}

Consistency RecentInnovations::consistency() const {
  Consistency consistency;
  for (double nis : nis_) {
    if (nis == kNotFused) {
      ++consistency.not_fused;
      continue;
    }
    ++consistency.fused;
    consistency.nis = nis;
    consistency.nis_mean += nis;
  }
  if (consistency.fused > 0) consistency.nis_mean /= consistency.fused;
  return consistency;
}

}  // namespace bearing_calibration::core
