// One filter step, prediction and update, of this package's filters and of the usual dense one of
// dynamic size, for its size.
#include <benchmark/benchmark.h>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/filter/paper_filter.h"
#include "bench/paper_run.h"
#include "bench/reference/dynamic_ekf.h"

namespace bearing_calibration::core {
namespace {

CartesianEstimate goodStart() {
  constexpr double kVariance = 1e-4;  // a centimetre, half a degree
  return {paperRun().truth.front(), kVariance * Matrix5::Identity()};
}

/// A run, over and over: each pass starts afresh, so that nothing can run away.
template <class MakeFilter, class Update>
void stepThroughRun(benchmark::State& state, const ObservationRun& run,
                    const MakeFilter& make_filter, const Update& update) {
  const std::vector<Observation>& observations = run.observations;
  auto filter = make_filter();
  std::size_t i = 1;
  for (auto _ : state) {
    filter->predict(observations[i].motion);
    update(*filter, observations[i]);
    if (++i < observations.size()) continue;
    filter = make_filter();
    i = 1;
  }
}

template <class MakeFilter>
void stepThroughRun(benchmark::State& state, const MakeFilter& make_filter) {
  stepThroughRun(state, paperRun(), make_filter, [](auto& filter, const Observation& observation) {
    filter.update(observation.azimuth_rad, observation.azimuth_variance_rad2);
  });
}

void cartesianStep(benchmark::State& state) {
  stepThroughRun(state, [] { return makeCartesianFilter({goodStart(), {}}); });
}
BENCHMARK(cartesianStep);

void paperStep(benchmark::State& state) {
  stepThroughRun(state, [] { return makePaperFilter(goodStart()); });
}
BENCHMARK(paperStep);

void dynamicStep(benchmark::State& state) {
  stepThroughRun(state, [&state] {
    return std::make_unique<reference::DynamicEkf>(goodStart(), state.range(0));
  });
}
BENCHMARK(dynamicStep)->Arg(5)->Arg(10)->Arg(15)->Arg(20)->Arg(30);

/// Light, mount and all errors of the robot.
RobotEstimate robotStart() {
  constexpr double kErrorVariance = 1e-4;  // a hundredth, 10 ms
  RobotEstimate start;
  start.cartesian = goodStart();
  start.errors.covariance = kErrorVariance * ErrorMatrix::Identity();
  return start;
}

/// With so many states in all: the first errors of the robot beside light and mount.
void robotStep(benchmark::State& state) {
  const RobotEstimate start = robotStart();
  const int errors_in_use = static_cast<int>(state.range(0)) - 5;
  stepThroughRun(state, [&] { return makeCartesianFilter(start, errors_in_use); });
}
BENCHMARK(robotStep)->Arg(9)->Arg(14)->Arg(17);  // the sizes that there are

/// With the elevation of each observation, which takes all errors.
void elevationStep(benchmark::State& state) {
  const RobotEstimate start = robotStart();
  stepThroughRun(
      state, elevationRun(), [&] { return makeCartesianFilter(start, kErrorCount); },
      [](auto& filter, const Observation& observation) {
        filter.update(observation.azimuth_rad, observation.azimuth_variance_rad2, {},
                      observation.elevation);
      });
}
BENCHMARK(elevationStep);

}  // namespace
}  // namespace bearing_calibration::core

BENCHMARK_MAIN();
