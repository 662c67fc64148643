#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/owner/bag_topics.h"

namespace bearing_calibration::core {

/// calibrate_bag's command line.
struct CalibrateBagArguments {
  std::vector<std::string> bags;
  std::vector<std::string> config_files;  ///< what differs from the package's own, in order
  std::vector<std::string> assignments;   ///< NAME=VALUE, after the files
  std::string output_folder;
  BagTopics topics;
  std::vector<int> light_ids;
  bool each_light = false;
  bool compare = false;
  bool quiet = false;
  int jobs = 0;
};

/// None when only help was asked for, which is printed then.
/// @throws boost::program_options::error
std::optional<CalibrateBagArguments> parseCalibrateBagArguments(int argc, char** argv);

}  // namespace bearing_calibration::core
