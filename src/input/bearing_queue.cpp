#include "bearing_calibration/input/bearing_queue.h"

#include <algorithm>
#include <utility>

namespace bearing_calibration::core {

bool BearingQueue::add(BearingSet bearings) {
  const auto place = std::upper_bound(
      waiting_.begin(), waiting_.end(), bearings.stamp,
      [](Stamp stamp, const BearingSet& waiting) { return stamp < waiting.stamp; });
  waiting_.insert(place, std::move(bearings));
  if (waiting_.size() <= capacity_) return true;
  waiting_.pop_front();
  return false;
}

BearingSet BearingQueue::takeOldest() {
  BearingSet oldest = std::move(waiting_.front());
  waiting_.pop_front();
  return oldest;
}

}  // namespace bearing_calibration::core
