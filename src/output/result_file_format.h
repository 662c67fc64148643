#pragma once

namespace bearing_calibration::core {

/// What the first two keys of a result file say; shared by its writer and its reader.
inline constexpr char kResultFileFormat[] = "bearing_calibration result";
inline constexpr int kResultFileVersion = 3;  ///< grows when an older program would misread

}  // namespace bearing_calibration::core
