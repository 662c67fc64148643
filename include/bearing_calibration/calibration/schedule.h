#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/record/observation_record.h"

namespace bearing_calibration::core {

/// How often a piece of work on a record is worth doing: not before an interval has passed, and
/// once the record has grown by a share of all that it has ever held, or by so many times what it
/// keeps: a drive of hours must not be looked at too rarely.
struct Pace {
  Duration interval;
  double growth;
  double most_per_kept = 10.0;
};

/// Of fits. A record that is nearly full is fitted, and gives its oldest part away, before it is.
inline Pace fitPace(double refit_growth) { return {std::chrono::seconds(1), refit_growth, 0.1}; }

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

  /// The work is done now.
  template <class Entry>
  void begin(const ThinnedRecord<Entry>& record, const Pace& pace) {
    const auto grown = static_cast<double>(record.grown());
    const auto kept = static_cast<double>(record.entries().size());
    earliest_ = record.entries().back().stamp + pace.interval;
    wanted_growth_ = record.grown() + static_cast<std::size_t>(std::ceil(std::min(
                                          pace.growth * grown, pace.most_per_kept * kept)));
  }

 private:
  Stamp earliest_;
  std::size_t wanted_growth_ = 0;
};

}  // namespace bearing_calibration::core
