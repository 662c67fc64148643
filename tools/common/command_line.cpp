#include "tools/common/command_line.h"

#include <cmath>
#include <exception>
#include <iostream>

namespace bearing_calibration::core {

namespace options = boost::program_options;

int runProgram(const char* name, const std::function<int()>& work, int failure_status) {
  try {
    return work();
  } catch (const options::error& error) {
    std::cerr << name << ": " << error.what() << " (see --help)\n";
    return kUsageError;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return failure_status;
  }
}

std::optional<options::variables_map> parseArguments(
    int argc, char** argv, const options::options_description& visible,
    const options::options_description& hidden,
    const options::positional_options_description& positions) {
  options::options_description all;
  all.add(visible).add(hidden);
  options::variables_map values;
  options::store(options::command_line_parser(argc, argv).options(all).positional(positions).run(),
                 values);
  if (values.count("help") != 0) {
    std::cout << visible << "\n";
    return std::nullopt;
  }
  try {
    options::notify(values);
  } catch (const options::required_option& error) {  // what is hidden is no option to its user
    const options::option_description* positional =
        hidden.find_nothrow(error.get_option_name().substr(2), false);
    if (positional == nullptr) throw;
    throw options::error(positional->description() + " is missing");
  }
  return values;
}

void requireGreaterThan0(const std::string& option, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw options::error("--" + option + " must be greater than 0");
}

}  // namespace bearing_calibration::core
