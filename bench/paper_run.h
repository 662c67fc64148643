#pragma once

#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// The paper's settings, second trajectory, seed 1: 1001 observations in 100 s. What every bench of
/// an estimator runs on.
inline const ObservationRun& paperRun() {
  static const ObservationRun run = simulate(paperCase(1));
  return run;
}

/// The same with elevations of 1 degree.
inline const ObservationRun& elevationRun() {
  static const ObservationRun run = [] {
    SimulatedCase simulated = paperCase(1);
    simulated.robot.sensor.elevation_stddev_rad = radiansFromDegrees(1.0);
    return simulate(simulated);
  }();
  return run;
}

}  // namespace bearing_calibration::core
