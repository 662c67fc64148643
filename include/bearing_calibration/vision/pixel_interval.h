#pragma once

namespace bearing_calibration {

/// Pixels [begin, end) of one row.
struct PixelInterval {
  int row = 0;
  int begin = 0;
  int end = 0;
};

}  // namespace bearing_calibration
