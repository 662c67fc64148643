#pragma once

#include <cstdint>
#include <istream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bearing_calibration/common/stamp.h"

namespace bearing_calibration::core {

/// A recording that cannot be used; what() says "file:line: what is wrong".
class RecordingError : public std::runtime_error {
 public:
  RecordingError(const std::string& file, std::size_t line, const std::string& sentence);
};

/// The two wheel counters at one moment.
struct CounterRow {
  Stamp stamp;
  std::int64_t left_ticks = 0;
  std::int64_t right_ticks = 0;
};

/// One observation of one landmark.
struct ObservationRow {
  Stamp stamp;
  double bearing_rad = 0.0;
};

/// How numbers of a recording become ticks and stamps.
struct RecordingUnits {
  double meters_per_tick = 0.0;  ///< > 0; only used where the recording has metres
  double start_time_s = 0.0;     ///< the stamp of t_s = 0
};

/// Wheel counters from a CSV file whose first line names its columns: `t_s,left_ticks,right_ticks`
/// (counts) or `t_s,left_m,right_m` (what each wheel has rolled since the row before). Increments
/// are summed up first and the sum is quantised, so that the ticks never drift from the metres.
/// A row that says the same counts at the same time once more is left out. `file` names the stream
/// in errors.
/// @throws RecordingError for a missing column, a cell that is not a finite number, a count that is
///   not whole, time that does not grow, a stamp that ROS cannot hold, or a file without rows.
std::vector<CounterRow> readCounters(std::istream& stream, const std::string& file,
                                     const RecordingUnits& units);

/// The observations of one landmark from columns `t_s,landmark_id,bearing_rad`, in the file's
/// order; all rows are checked.
/// @throws RecordingError as above (equal times are allowed: one scan sees several landmarks), and
///   when the landmark is never seen.
std::vector<ObservationRow> readObservations(std::istream& stream, const std::string& file,
                                             std::int32_t landmark_id, const RecordingUnits& units);

}  // namespace bearing_calibration::core
