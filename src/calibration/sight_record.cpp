#include "bearing_calibration/calibration/sight_record.h"

#include <algorithm>

#include "bearing_calibration/common/requirement.h"
#include "bearing_calibration/common/validated.h"

namespace bearing_calibration {
namespace {

/// How much of the record's room a motion deserves [m]. A turn on the spot brings the same views
/// again after a while, so that it counts little, and never more than a radian of it: an hour of
/// spinning must not crowd out a metre of driving.
double importance(const OdometryIncrement& motion) {
  constexpr double kLever_m = 0.05;
  constexpr double kMostTurn_rad = 1.0;
  return motion.distance_m + kLever_m * std::min(motion.rotation_rad, kMostTurn_rad);
}

}  // namespace

std::vector<std::string> SightRecordConfig::validate() const {
  constexpr std::size_t kSmallestRecord = 100;  // below it, thinning costs accuracy at once
  Requirements require;
  require.that(capacity >= kSmallestRecord, "record/capacity must be at least " +
                                                std::to_string(kSmallestRecord) + ", but is " +
                                                std::to_string(capacity));
  require.notNegative("record/still_distance", still_distance_m);
  require.notNegative("record/still_turn", still_turn_rad);
  require.that(repetitions >= 0,
               "record/repetitions must not be negative, but is " + std::to_string(repetitions));
  return require.errors();
}

SightRecord::SightRecord(const SightRecordConfig& config) : config_(validated(config)) {
  sights_.reserve(config_.capacity + 1);
}

void SightRecord::clear() {
  sights_.clear();
  repetitions_ = 0;
}

bool SightRecord::isRepetition(const Sight& sight) const {
  return sight.motion.distance_m < config_.still_distance_m &&
         sight.motion.rotation_rad < config_.still_turn_rad;
}

void SightRecord::removeInner(std::size_t index) {
  Sight& next = sights_[index + 1];
  next.motion = append(sights_[index].motion, next.motion);
  sights_.erase(sights_.begin() + static_cast<std::ptrdiff_t>(index));
}

void SightRecord::add(const Sight& sight) {
  sights_.push_back(sight);
  repetitions_ = isRepetition(sight) && sights_.size() > 1 ? repetitions_ + 1 : 0;
  if (repetitions_ > config_.repetitions) {
    removeInner(sights_.size() - 2);
    repetitions_ = isRepetition(sights_.back()) ? repetitions_ - 1 : 0;
  }
  if (sights_.size() <= config_.capacity) return;

  std::size_t least = 1;
  double least_importance = importance(sights_[1].motion) + importance(sights_[2].motion);
  for (std::size_t i = 2; i + 1 < sights_.size(); ++i) {
    const double candidate = importance(sights_[i].motion) + importance(sights_[i + 1].motion);
    if (candidate < least_importance) {
      least = i;
      least_importance = candidate;
    }
  }
  removeInner(least);
}

}  // namespace bearing_calibration
