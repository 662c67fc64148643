#pragma once

#include <cstdint>

namespace bearing_calibration::core {

/// Where fits, which take up to a second, are done.
enum class FitsRun : std::uint8_t {
  kAtOnce,  ///< within the input that makes them due: the same inputs, the same results
  kBeside,  ///< on another thread: an input takes no longer than the filter does
};

/// What became of the fits that run beside.
struct FitsReport {
  bool under_way = false;     ///< begun, and not yet taken over
  std::uint32_t taken = 0;    ///< taken over
  std::uint32_t dropped = 0;  ///< because what they were begun on no longer holds
};

}  // namespace bearing_calibration::core
