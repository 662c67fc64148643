#pragma once

#include <string>
#include <vector>

#include "tools/study/monte_carlo_table.h"

namespace bearing_calibration::core {

/// Something that must hold, judged on a sample: missed only where the sample rules it out.
struct Bar {
  std::string sentence;
  double value = 0.0;  ///< as measured
  double limit = 0.0;  ///< what a system that just holds it stays on the right side of, 999 of 1000
  bool reached = false;
};

/// What a claim is worth.
enum class ClaimKind {
  kVerdict,    ///< CONVERGED: never wrong
  kEstimate,   ///< ready, or settled: a Gaussian's tail may be a little too long
  kForbidden,  ///< from degenerate motion: none may be made
};

/// The bars of accuracy.md that the trials speak of.
std::vector<Bar> judgeBars(const std::vector<Trial>& trials, const std::vector<TableRow>& rows,
                           ClaimKind kind);
std::string format(const std::vector<Bar>& bars);
bool allReached(const std::vector<Bar>& bars);

}  // namespace bearing_calibration::core
