#pragma once

namespace bearing_calibration::core {

/// Pixels [begin, end) of each of so many rows from `row` on. In a list in reading order a strip of
/// several rows has these rows for itself.
struct PixelStrip {
  int row = 0;
  int begin = 0;
  int end = 0;
  int rows = 1;
};

}  // namespace bearing_calibration::core
