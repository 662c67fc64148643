// Prints how to drive a calibration by hand: drive_instructions [corner_light|dance]

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "bearing_calibration/planning/drive_motion.h"

int main(int argc, char** argv) {
  using namespace bearing_calibration;
  constexpr int kUsageError = 2;
  const std::string wanted = argc > 1 ? argv[1] : "corner_light";
  const std::vector<std::string>& names = motionNames();
  const auto found = std::find(names.begin(), names.end(), wanted);
  if (found == names.end()) {
    std::fprintf(stderr, "usage: drive_instructions [corner_light|dance]\n");
    return kUsageError;
  }
  int number = 0;
  for (const std::string& step : instructionsFor(static_cast<DriveMotion>(found - names.begin()))) {
    std::printf("%d. %s\n", ++number, step.c_str());
  }
  return 0;
}
