// Prints how to drive a calibration by hand: drive_instructions [corner_light|dance]

#include <cstdio>
#include <string>

#include "bearing_calibration/planning/drive_script.h"

int main(int argc, char** argv) {
  using namespace bearing_calibration::core;
  constexpr int kUsageError = 2;
  const auto motion = motionNamed(argc > 1 ? argv[1] : "corner_light");
  if (!motion) {
    std::fprintf(stderr, "usage: drive_instructions [corner_light|dance]\n");
    return kUsageError;
  }
  int number = 0;
  for (const std::string& step : instructionsFor(*motion)) {
    std::printf("%d. %s\n", ++number, step.c_str());
  }
  return 0;
}
