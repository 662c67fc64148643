// Prints how to drive a calibration by hand: drive_instructions --help

#include <cstdio>
#include <cstring>
#include <string>

#include "bearing_calibration/planning/drive_script.h"

int main(int argc, char** argv) {
  using namespace bearing_calibration::core;
  constexpr int kUsageError = 2;
  while (argc > 1 && std::strstr(argv[argc - 1], ":=") != nullptr) --argc;  // roslaunch's
  const std::string word = argc > 1 ? argv[1] : "corner_light";
  const bool is_help = word == "-h" || word == "--help";
  const auto motion = motionNamed(word);
  if (is_help || !motion || argc > 2) {
    std::fprintf(is_help ? stdout : stderr,
                 "usage: drive_instructions [corner_light|dance]\n"
                 "Prints how to drive a calibration by hand, step by step.\n");
    return is_help ? 0 : kUsageError;
  }
  int number = 0;
  for (const std::string& step : instructionsFor(*motion)) {
    std::printf("%d. %s\n", ++number, step.c_str());
  }
  return 0;
}
