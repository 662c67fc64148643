// libFuzzer's entry: scripts/fuzz

#include "fuzz/harness.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  bearing_calibration::fuzz::run(data, size);  // an exception ends the program: it is a finding
  return 0;
}
