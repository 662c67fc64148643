// libFuzzer's entry: scripts/fuzz

#include "fuzz/detection_fuzzer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static bearing_calibration_ros::DetectionFuzzer fuzzer;
  fuzzer.run(data, size);  // an exception ends the program, which is a finding
  return 0;
}
