#pragma once

#include <cmath>
#include <cstddef>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/record/observation_record.h"

namespace bearing_calibration::core {

/// How often a piece of work on a record is worth doing: not before an interval has passed, and
/// once the record has grown by a share of itself.
struct Pace {
  Duration interval;
  double growth;
};

/// When it is to be done again. The time that has passed never delays it: a robot that has stood
/// for a day, which adds nothing, goes on as one that has not.
class Schedule {
 public:
  bool isDue(const ObservationRecord& record) const {
    return isTime(record) && record.grown() >= wanted_growth_;
  }
  /// The same for work that cannot wait until the record has grown.
  bool isTime(const ObservationRecord& record) const {
    return record.observations().back().stamp >= earliest_;
  }

  /// The work is done now.
  void begin(const ObservationRecord& record, const Pace& pace) {
    const double growth = pace.growth * static_cast<double>(record.observations().size());
    earliest_ = record.observations().back().stamp + pace.interval;
    wanted_growth_ = record.grown() + static_cast<std::size_t>(std::ceil(growth));
  }

 private:
  Stamp earliest_;
  std::size_t wanted_growth_ = 0;
};

}  // namespace bearing_calibration::core
