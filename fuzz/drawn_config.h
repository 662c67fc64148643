#pragma once

#include "bearing_calibration/calibration/config.h"
#include "fuzz/byte_reader.h"

namespace bearing_calibration::fuzz {

/// A calibrator's configuration that is valid: as shipped, or with some of its declared parameters
/// multiplied by a factor, each as the bytes say. One that is not valid must be refused by the
/// calibrator, and is shipped's.
core::CalibratorConfig drawConfig(ByteReader* bytes);

}  // namespace bearing_calibration::fuzz
