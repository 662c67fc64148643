#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bearing_calibration/filter/cartesian_state.h"

namespace bearing_calibration {

/// How a record stays small.
struct SightRecordConfig {
  std::size_t capacity = 1200;  ///< sights: 2 min at 10 Hz before the first is thinned out
  /// A sight that moved less than both from the one before it is a repetition: of those only
  /// `repetitions` are kept, so that a standing robot adds neither length nor false certainty.
  double still_distance_m = 0.002;
  double still_turn_rad = 0.002;
  int repetitions = 20;

  std::vector<std::string> validate() const;
};

/// A bounded record of sights that forgets motion last: a standing robot costs no room, and when
/// the room is used up, the sight with the least motion around it gives way, its motion carried on.
/// So an endless record is kept whole, only more coarsely.
class SightRecord {
 public:
  /// @throws std::invalid_argument with every sentence of config.validate().
  explicit SightRecord(const SightRecordConfig& config);

  void add(const Sight& sight);
  void clear();

  /// In the order of time, the last one added always at the end; the motion of each is since the
  /// one before it in this list.
  const std::vector<Sight>& sights() const { return sights_; }

 private:
  bool isRepetition(const Sight& sight) const;
  void removeInner(std::size_t index);

  SightRecordConfig config_;
  std::vector<Sight> sights_;
  int repetitions_ = 0;  ///< sights at the end that repeat the one before them
};

}  // namespace bearing_calibration
