#pragma once

#include <string>

namespace bearing_calibration_ros {

/// Why a message cannot be used.
struct Refusal {
  std::string kind;  ///< the same word for the same fault: counted by it
  std::string text;  ///< with the values
};

}  // namespace bearing_calibration_ros
