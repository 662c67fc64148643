#pragma once

#include <algorithm>
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
  template <class Entry>
  bool isDue(const ThinnedRecord<Entry>& record) const {
    return isTime(record) && record.grown() >= wanted_growth_;
  }
  /// The same for work that cannot wait until the record has grown.
  template <class Entry>
  bool isTime(const ThinnedRecord<Entry>& record) const {
    return record.entries().back().stamp >= earliest_;
  }

  /// The work is done now. A full record stands for all that it has ever held, but for so much at
  /// most that a drive of hours is not looked at too rarely.
  template <class Entry>
  void begin(const ThinnedRecord<Entry>& record, const Pace& pace) {
    constexpr std::size_t kMostOfKept = 10;
    const std::size_t size = std::min(record.grown(), kMostOfKept * record.entries().size());
    earliest_ = record.entries().back().stamp + pace.interval;
    wanted_growth_ = record.grown() +
                     static_cast<std::size_t>(std::ceil(pace.growth * static_cast<double>(size)));
  }

 private:
  Stamp earliest_;
  std::size_t wanted_growth_ = 0;
};

}  // namespace bearing_calibration::core
