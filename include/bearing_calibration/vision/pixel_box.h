#pragma once

namespace bearing_calibration::core {

/// Rows and columns from the first ones to before the last ones.
struct PixelBox {
  int first_row = 0;
  int last_row = 0;
  int first_column = 0;
  int last_column = 0;
};

}  // namespace bearing_calibration::core
