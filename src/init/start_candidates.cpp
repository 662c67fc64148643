#include "bearing_calibration/init/start_candidates.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/cancellation.h"

namespace bearing_calibration::core {
namespace {

/// More than the five unknowns, so that noise averages out, and few enough to be free of outliers
/// now and then: with 30 % outliers, one draw in 25 is.
constexpr std::size_t kObservationsPerDraw = 9;
constexpr int kDraws = 100;
/// With 20 % outliers one draw in 8 is free of them; neighbouring hypotheses make up for each
/// other.
constexpr int kDrawsOfMany = 25;
constexpr std::size_t kLeastWindow = 2 * kObservationsPerDraw;

/// One observation from each of equal parts of the window.
std::optional<Vector5> solveDraw(const std::vector<PosedObservation>& observations,
                                 std::mt19937& random) {
  ClosedForm form;
  for (std::size_t part = 0; part < kObservationsPerDraw; ++part) {
    const std::size_t begin = part * observations.size() / kObservationsPerDraw;
    const std::size_t end = (part + 1) * observations.size() / kObservationsPerDraw;
    form.add(observations[begin + random() % (end - begin)], 1.0);
  }
  return form.solve();
}

/// The closed form on all observations that agree with `state`; on all observations when there is
/// no state. The error of a row of the closed form grows with the light's range, hence the weights.
std::optional<Vector5> resolve(const std::vector<PosedObservation>& observations,
                               const PosedObservation& reference,
                               const std::optional<Vector5>& state) {
  constexpr double kInlierSigmas = 3.0;
  ClosedForm form;
  for (const PosedObservation& observation : observations) {
    double weight = 1.0;
    if (state) {
      const double range = rangeOf(stateAt(observation, *state));
      const double stddev = bearingStddev(observation, reference, range);
      if (std::abs(residualAt(observation, *state)) > kInlierSigmas * stddev) continue;
      weight = 1.0 / (stddev * stddev * std::max(range * range, 1e-4));
    }
    form.add(observation, weight);
  }
  const std::optional<Vector5> solved = form.solve();
  if (!solved) return state;
  return withLightInFront(observations, *solved);
}

void keepBetter(const std::vector<PosedObservation>& observations,
                const std::optional<Vector5>& state, const FixedPathWeight& weight,
                std::optional<FixedPathFit>& best) {
  if (!state) return;
  const FixedPathFit fit = judgeOnFixedPath(observations, *state, weight);
  if (!best || fit.capped_cost < best->capped_cost) best = fit;
}

}  // namespace

std::vector<Stretch> startWindows(std::size_t observations) {
  constexpr std::size_t kFinest = 4;
  std::vector<Stretch> windows;
  for (std::size_t parts = 1; parts <= kFinest; parts *= 2) {
    if (observations / parts < kLeastWindow) break;
    for (std::size_t i = 0; i < parts; ++i) {
      windows.push_back({i * observations / parts, (i + 1) * observations / parts});
    }
  }
  return windows;
}

FixedPathFit findConsensus(const std::vector<PosedObservation>& all, const Stretch& window,
                           std::uint32_t seed, bool one_of_many) {
  const std::vector<PosedObservation> observations(
      all.begin() + static_cast<std::ptrdiff_t>(window.begin),
      all.begin() + static_cast<std::ptrdiff_t>(window.end));
  const FixedPathWeight weight{observations.size() / 2};
  const PosedObservation& reference = observations[weight.reference];
  std::mt19937 random(seed);

  std::optional<FixedPathFit> best;
  std::optional<Vector5> plain = resolve(observations, reference, std::nullopt);
  keepBetter(observations, plain, weight, best);
  const int draws = one_of_many ? kDrawsOfMany : kDraws;
  for (int draw = 0; draw < draws; ++draw) {
    endIfCancelled();
    const std::optional<Vector5> drawn = solveDraw(observations, random);
    if (drawn) keepBetter(observations, withLightInFront(observations, *drawn), weight, best);
  }
  if (!best) return {};
  for (int i = 0; i < 2; ++i) {
    keepBetter(observations, resolve(observations, reference, best->state_at_first), weight, best);
  }
  return fitOnFixedPath(observations, best->state_at_first, weight);
}

std::vector<FixedPathFit> findOtherMinima(const std::vector<PosedObservation>& observations,
                                          const Vector5& found, double within_m) {
  const FixedPathWeight weight{observations.size() / 2};
  ClosedForm form;
  for (const PosedObservation& observation : observations) form.add(observation, 1.0);
  std::vector<FixedPathFit> minima;
  for (int i = 0; i < kYawsAround; ++i) {
    const std::optional<Vector5> start = form.solveFor(2.0 * kPi * i / kYawsAround);
    if (!start) continue;
    const FixedPathFit fit = fitOnFixedPath(observations, *start, weight);
    const bool known = isSameMount(fit.state_at_first, found, within_m) ||
                       std::any_of(minima.begin(), minima.end(), [&](const FixedPathFit& other) {
                         return isSameMount(fit.state_at_first, other.state_at_first, within_m);
                       });
    if (!known) minima.push_back(fit);
  }
  std::sort(minima.begin(), minima.end(),
            [](const FixedPathFit& a, const FixedPathFit& b) { return a.cost < b.cost; });
  return minima;
}

double sameMountWithin(double extent_m) {
  constexpr double kMost_m = 0.1;
  constexpr double kPerExtent = 0.25;
  return std::min(kMost_m, kPerExtent * extent_m);
}

bool isSameMount(const Vector5& a, const Vector5& b, double within_m) {
  constexpr double kYaw_rad = 0.15;
  return (a - b).segment<2>(CartesianIndex::kSensorX).norm() < within_m &&
         std::abs(wrapAngle(a(CartesianIndex::kSensorYaw) - b(CartesianIndex::kSensorYaw))) <
             kYaw_rad;
}

}  // namespace bearing_calibration::core
