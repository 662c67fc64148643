#pragma once

#include <string>
#include <vector>

#include "bearing_calibration/judge/fault.h"
#include "tools/study/simulated_case.h"

namespace bearing_calibration::core {

/// One way in which a robot is not what its owner believes.
struct FaultCase {
  std::string name;
  Fault fault = Fault::kNone;
  void (*make)(SimulatedCase* simulated) = nullptr;  ///< on a sound robot
  bool keeps_mount = true;                           ///< the mount is the same in all of the run
};

/// A sound robot, and one with each fault of faults.md.
const std::vector<FaultCase>& faultCases();

}  // namespace bearing_calibration::core
