// Runs this package's calibrator and other estimators on the same simulated data and prints how far
// each is off, how honest it is and what it costs: comparison_table --help

#include <boost/program_options.hpp>
#include <cstdlib>
#include <iostream>

#include "tools/common/command_line.h"
#include "tools/study/comparison.h"

namespace bearing_calibration::core {
namespace {

namespace options = boost::program_options;

int run(int argc, char** argv) {
  int runs = 0;
  int threads = 0;
  options::options_description description("comparison_table [options]");
  auto add = description.add_options();
  add("help,h", "print this");
  add("runs", options::value(&runs)->default_value(40), "in each setting");
  add("threads", options::value(&threads)->default_value(2), "at work");
  if (!parseArguments(argc, argv, description)) return EXIT_SUCCESS;
  requireGreaterThan0("runs", runs);
  requireGreaterThan0("threads", threads);
  std::cout << formatGiven();
  for (const ComparisonSetting& setting : comparisonSettings()) {
    std::cout << "\n" << formatComparison(setting, compare(setting, runs, threads)) << std::flush;
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace bearing_calibration::core

int main(int argc, char** argv) {
  return bearing_calibration::core::runProgram(
      "comparison_table", [&] { return bearing_calibration::core::run(argc, argv); },
      bearing_calibration::core::kUsageError);
}
