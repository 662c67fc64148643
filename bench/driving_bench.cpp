// Cost of one decision of the planner: the bar is 5 ms on one core. Nothing is asserted.
#include <benchmark/benchmark.h>

#include "bearing_calibration/planning/motion_planner.h"

namespace bearing_calibration::core {
namespace {

/// A decision at the light's distance of `range(0)` centimetres, the robot's errors looked for as
/// config/calibration.yaml has it.
void decision(benchmark::State& state) {
  const MotionPlanner planner({PlannerConfig::Block::kMount, 0.5, 2.0, 0.1, 1.0}, {0.25, 0.2, 0.5},
                              {{1e-6, 0.0}, 0.0175, 10.0}, {4.0, {}});
  CartesianEstimate start;
  start.mean << 0.01 * static_cast<double>(state.range(0)), 0.0, 0.08, 0.05, 1.0;
  start.covariance = 1e-4 * Matrix5::Identity();
  ErrorPriors errors;
  errors.setBlock(TimeOffset::kName, 0.1);
  errors.setBlock(WheelScales::kName, 0.03);
  errors.setBlock(WheelSeparation::kName, 0.01);
  const StateEstimate known = StateEstimate::of(start, kWheelErrors, priorEstimate(errors));
  for (auto _ : state) benchmark::DoNotOptimize(planner.plan(known, {}));
}
BENCHMARK(decision)->Arg(60)->Arg(100)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace bearing_calibration::core

BENCHMARK_MAIN();
