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

Bearing bearingOf(const Observation& observation) {
  Bearing bearing;
  bearing.azimuth_rad = observation.azimuth_rad;
  bearing.azimuth_variance_rad2 = observation.azimuth_variance_rad2;
  if (!observation.elevation) return bearing;
  bearing.elevation_rad = observation.elevation->angle_rad;
  bearing.elevation_variance_rad2 = observation.elevation->variance_rad2;
  return bearing;
}

/// A run, over and over: each pass starts afresh, so that nothing can run away.
template <class Filter, class Update>
void stepThroughRun(benchmark::State& state, const ObservationRun& run, const Filter& start,
                    const Update& update) {
  const std::vector<Observation>& observations = run.observations;
  Filter filter = start;
  std::size_t i = 1;
  for (auto _ : state) {
    filter.predict(observations[i].motion);
    update(observations[i], &filter);
    if (++i < observations.size()) continue;
    filter = start;
    i = 1;
  }
}

void stepThroughRun(benchmark::State& state, const ObservationRun& run, const LiveFilter& start) {
  stepThroughRun(state, run, start, [](const Observation& observation, LiveFilter* filter) {
    filter->update(bearingOf(observation));
  });
}

void cartesianStep(benchmark::State& state) {
  stepThroughRun(state, paperRun(), LiveFilter(StateEstimate::of(goodStart())));
}
BENCHMARK(cartesianStep);

void paperStep(benchmark::State& state) {
  stepThroughRun(state, paperRun(), PaperFilter(paperFromCartesian(goodStart())),
                 [](const Observation& observation, PaperFilter* filter) {
                   filter->update(observation.azimuth_rad, observation.azimuth_variance_rad2);
                 });
}
BENCHMARK(paperStep);

void dynamicStep(benchmark::State& state) {
  stepThroughRun(state, paperRun(), reference::DynamicEkf(goodStart(), state.range(0)),
                 [](const Observation& observation, reference::DynamicEkf* filter) {
                   filter->update(observation.azimuth_rad, observation.azimuth_variance_rad2);
                 });
}
BENCHMARK(dynamicStep)->Arg(5)->Arg(10)->Arg(15)->Arg(20)->Arg(30);

/// Light, mount and the first errors of the robot.
LiveFilter robotStart(std::int64_t states) {
  constexpr double kErrorVariance = 1e-4;  // a hundredth, 10 ms
  return LiveFilter(
      StateEstimate::of(goodStart(), static_cast<int>(states) - 5,
                        {ErrorVector::Zero(), kErrorVariance * ErrorMatrix::Identity()}));
}

/// With so many states in all.
void robotStep(benchmark::State& state) {
  stepThroughRun(state, paperRun(), robotStart(state.range(0)));
}
BENCHMARK(robotStep)->Arg(5 + kWheelErrors)->Arg(5 + placeOf<SensorTilt>())->Arg(5 + heightAt(1));

/// With the elevation of each observation, which takes all errors.
void elevationStep(benchmark::State& state) {
  stepThroughRun(state, elevationRun(), robotStart(5 + heightAt(1)));
}
BENCHMARK(elevationStep);

}  // namespace
}  // namespace bearing_calibration::core

BENCHMARK_MAIN();
