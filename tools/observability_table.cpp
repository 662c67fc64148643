// Prints what the bearings of a motion determine: the table of ranks in doc/model.md.

#include <cstdio>

#include "tools/observability_ranks.h"

int main() {
  std::fputs(
      bearing_calibration::observabilityTable(bearing_calibration::observabilityCases()).c_str(),
      stdout);
  return 0;
}
