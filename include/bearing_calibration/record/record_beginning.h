#pragma once

#include <cstddef>

#include "bearing_calibration/filter/state.h"
#include "bearing_calibration/record/scatter.h"

namespace bearing_calibration::core {

/// What is known where a record begins that goes on from an earlier one: nothing of that is lost,
/// but that its bearings and motions stay linearised where they were.
struct RecordBeginning {
  /// Mount, errors and lights at the last observation before the record's first one, its bearing
  /// counted, in the base frame of then. Priors of the errors are in it.
  StateEstimate known;
  double distance_m = 0.0;    ///< driven until there
  double rotation_rad = 0.0;  ///< turned until there, to either side
  Scatter scatter;            ///< of the mounts that the drive until there told
};

/// The first entries of a record, to be given away for what they say.
struct RecordPart {
  std::size_t count = 0;
  StateEstimate known;  ///< at the last of them, from everything until there
  Scatter scatter;      ///< of the mounts that they tell
};

}  // namespace bearing_calibration::core
