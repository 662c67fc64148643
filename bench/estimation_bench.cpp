// How the start and the batch scale with what they are given: observations, and errors of the
// robot.
#include <benchmark/benchmark.h>

#include <vector>

#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/solve/batch_estimator.h"
#include "bench/paper_run.h"

namespace bearing_calibration::core {
namespace {

/// One attempt of the initialiser on the first `range` observations.
void attempt(benchmark::State& state) {
  const auto& all = paperRun().observations;
  const std::vector<Observation> observations(all.begin(), all.begin() + state.range(0));
  const InitializerConfig config;
  for (auto _ : state) benchmark::DoNotOptimize(findStart(observations, config));
}
BENCHMARK(attempt)->Arg(150)->Arg(300)->Arg(1000)->Unit(benchmark::kMillisecond);

/// The batch over the whole run with `range` states: light, mount, and the first errors of the
/// robot; all of them have elevations to use.
void batchStates(benchmark::State& state) {
  constexpr double kErrorStddev = 0.01;
  const ObservationRun& run = elevationRun();
  BatchConfig config;
  config.errors.stddev.head(state.range(0) - 5).setConstant(kErrorStddev);
  if (config.errors.usesElevations()) {
    // the heights of lights that are not there are no states, but have a prior
    config.errors.stddev.segment<SensorTilt::kSize>(placeOf<SensorTilt>())
        .setConstant(kErrorStddev);
  }
  const BatchEstimator estimator{config};
  const RecordStart start{run.truth.back(), run.observations.size() - 1};
  for (auto _ : state) benchmark::DoNotOptimize(estimator.estimate(run.observations, start));
}
BENCHMARK(batchStates)
    ->Arg(5)
    ->Arg(5 + kWheelErrors)
    ->Arg(5 + placeOf<SensorTilt>())
    ->Arg(5 + heightAt(1))
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bearing_calibration::core

BENCHMARK_MAIN();
