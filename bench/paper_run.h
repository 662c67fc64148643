#pragma once

#include "tools/simulated_case.h"

namespace bearing_calibration {

/// The paper's settings, second trajectory, seed 1: 1001 sights in 100 s. What every bench of an
/// estimator runs on.
inline const SightRun& paperRun() {
  static const SightRun run = simulate(paperCase(1));
  return run;
}

}  // namespace bearing_calibration
