#pragma once

#include <cmath>
#include <cstddef>

#include "bearing_calibration/calibration/sight_record.h"
#include "bearing_calibration/common/stamp.h"

namespace bearing_calibration {

/// How often a piece of work on a record is worth doing: not before an interval has passed, and
/// once the record has grown by a share of itself.
struct Pace {
  Duration interval;
  double growth;
};

/// When it is to be done again. The time that has passed never delays it: a robot that has stood for
/// a day, which adds nothing, goes on as one that has not.
class Schedule {
 public:
  bool isDue(const SightRecord& record) const {
    return isTime(record) && record.grown() >= wanted_growth_;
  }
  /// The same for work that cannot wait until the record has grown.
  bool isTime(const SightRecord& record) const { return record.sights().back().stamp >= earliest_; }

  /// The work is done now.
  void begin(const SightRecord& record, const Pace& pace) {
    const double growth = pace.growth * static_cast<double>(record.sights().size());
    earliest_ = record.sights().back().stamp + pace.interval;
    wanted_growth_ = record.grown() + static_cast<std::size_t>(std::ceil(growth));
  }

 private:
  Stamp earliest_;
  std::size_t wanted_growth_ = 0;
};

}  // namespace bearing_calibration
