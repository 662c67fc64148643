#pragma once

#include <deque>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Bearings that wait for the ticks that cover them, in the order of their stamps.
class BearingQueue {
 public:
  explicit BearingQueue(std::size_t capacity) : capacity_(capacity) {}

  /// Returns false when the oldest one had to be dropped to make room.
  bool add(BearingSet bearings);
  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  Stamp oldest() const { return waiting_.front().stamp; }
  BearingSet takeOldest();
  void clear() { waiting_.clear(); }

 private:
  std::size_t capacity_;
  std::deque<BearingSet> waiting_;
};

}  // namespace bearing_calibration::core
