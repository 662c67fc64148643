#include "bearing_calibration/track/hidden_turn.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

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

}  // namespace bearing_calibration::core
