#include "bearing_calibration/record/observation_record.h"

#include <algorithm>

#include "bearing_calibration/record/lights_record.h"

namespace bearing_calibration::core {
namespace {

/// How much of the record's room a motion deserves [m]. A turn on the spot brings the same views
/// again after a while, so that it counts little, and never more than a radian of it: an hour of
/// spinning must not crowd out a metre of driving.
double importance(const OdometryIncrement& motion) {
  constexpr double kLever_m = 0.05;
  constexpr double kMostTurn_rad = 1.0;
  return motion.distance_m + kLever_m * std::min(motion.rotation_rad, kMostTurn_rad);
}

bool isRepetition(const OdometryIncrement& motion) {
  constexpr double kStill_m = 0.002;
  constexpr double kStill_rad = 0.002;
  return motion.distance_m < kStill_m && motion.rotation_rad < kStill_rad;
}

}  // namespace

void ObservationRecordConfig::declare(Parameters& params) {
  constexpr std::size_t kSmallestRecord = 100;  // below it, thinning costs accuracy at once
  params.that(capacity >= kSmallestRecord, "record/capacity must be at least " +
                                               std::to_string(kSmallestRecord) + ", but is " +
                                               std::to_string(capacity));
}

template <class Entry>
ThinnedRecord<Entry>::ThinnedRecord(const ObservationRecordConfig& config)
    : config_(validated(config)) {
  entries_.reserve(config_.capacity + 1);
}

template <class Entry>
void ThinnedRecord<Entry>::clear() {
  entries_.clear();
  repetitions_ = 0;
  grown_ = 0;
  beginning_.reset();
}

template <class Entry>
void ThinnedRecord<Entry>::removeInner(std::size_t index) {
  Entry& next = entries_[index + 1];
  next.motion = append(entries_[index].motion, next.motion);
  entries_.erase(entries_.begin() + static_cast<std::ptrdiff_t>(index));
}

template <class Entry>
void ThinnedRecord<Entry>::add(const Entry& entry) {
  entries_.push_back(entry);
  ++grown_;
  repetitions_ = isRepetition(entry.motion) && entries_.size() > 1 ? repetitions_ + 1 : 0;
  if (repetitions_ > kMostRepetitions) {
    removeInner(entries_.size() - 2);
    --grown_;
    repetitions_ = isRepetition(entries_.back().motion) ? repetitions_ - 1 : 0;
  }
  if (entries_.size() <= config_.capacity) return;

  std::size_t least = 1;
  double least_importance = importance(entries_[1].motion) + importance(entries_[2].motion);
  for (std::size_t i = 2; i + 1 < entries_.size(); ++i) {
    const double candidate = importance(entries_[i].motion) + importance(entries_[i + 1].motion);
    if (candidate < least_importance) {
      least = i;
      least_importance = candidate;
    }
  }
  removeInner(least);
}

template <class Entry>
std::size_t ThinnedRecord<Entry>::surplus() const {
  const bool is_nearly_full = entries_.size() > config_.capacity - config_.capacity / 10;
  return is_nearly_full ? config_.capacity / 4 : 0;
}

template <class Entry>
void ThinnedRecord<Entry>::cut(const RecordPart& part) {
  RecordBeginning beginning = beginning_.value_or(RecordBeginning{});
  beginning.known = part.known;
  beginning.scatter.giveAway(part.scatter);
  const auto end = entries_.begin() + static_cast<std::ptrdiff_t>(part.count);
  for (auto entry = entries_.begin(); entry != end; ++entry) {
    if (!beginning_ && entry == entries_.begin()) continue;  // its motion counts as none
    beginning.distance_m += entry->motion.distance_m;
    beginning.rotation_rad += entry->motion.rotation_rad;
  }
  entries_.erase(entries_.begin(), end);
  beginning_ = beginning;
}

template class ThinnedRecord<Observation>;
template class ThinnedRecord<LightsImage>;

}  // namespace bearing_calibration::core
