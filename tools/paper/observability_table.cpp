// Prints what the bearings of a motion determine: the table of ranks in model.md.

#include <cstdio>

#include "tools/paper/observability_ranks.h"

int main() {
  std::fputs(
      bearing_calibration::core::observabilityTable(bearing_calibration::core::observabilityCases())
          .c_str(),
      stdout);
  return 0;
}
