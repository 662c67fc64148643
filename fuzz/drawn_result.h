#pragma once

#include "bearing_calibration/output/result_file.h"
#include "fuzz/byte_reader.h"

namespace bearing_calibration::fuzz {

/// A calibration that could be: any state, texts, counts and finite numbers, covariances that are
/// some.
core::SavedCalibration drawResult(ByteReader* bytes);

}  // namespace bearing_calibration::fuzz
