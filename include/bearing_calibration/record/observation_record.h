#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/record/record_beginning.h"

namespace bearing_calibration::core {

/// How a record stays small.
struct ObservationRecordConfig {
  std::size_t capacity = 1200;  ///< observations: 2 min at 10 Hz

  void declare(Parameters& params);
};

/// An observation that hardly moved from the one before it is a repetition: so many of those in a
/// row are kept, that a standing robot adds neither length nor false certainty.
inline constexpr int kMostRepetitions = 20;

/// A bounded record that forgets motion last: a standing robot costs no room, and when the room is
/// used up, the entry with the least motion around it gives way, its motion carried on. So a record
/// that nobody cuts is kept whole, only more coarsely. An entry has its `motion` since the one
/// before it; instances are made in the source file.
template <class Entry>
class ThinnedRecord {
 public:
  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit ThinnedRecord(const ObservationRecordConfig& config);

  void add(const Entry& entry);
  void clear();

  /// In the order of time, the last one added always at the end; the motion of each is since the
  /// one before it in this list.
  const std::vector<Entry>& entries() const { return entries_; }
  /// Entries that were ever added, but for repetitions that were not kept: what has grown by a
  /// share is worth another look, however long it took.
  std::size_t grown() const { return grown_; }

  /// None while the record is whole.
  const std::optional<RecordBeginning>& beginning() const { return beginning_; }
  /// So many of the oldest entries should be given away now: none until the record is nearly full.
  std::size_t surplus() const;
  /// Gives away the first entries for what they say.
  void cut(const RecordPart& part);

 protected:
  std::vector<Entry>& changeable() { return entries_; }

 private:
  void removeInner(std::size_t index);

  ObservationRecordConfig config_;
  std::vector<Entry> entries_;
  int repetitions_ = 0;  ///< entries at the end that repeat the one before them
  std::size_t grown_ = 0;
  std::optional<RecordBeginning> beginning_;
};

/// The record of one light's observations.
class ObservationRecord : public ThinnedRecord<Observation> {
 public:
  using ThinnedRecord::ThinnedRecord;
  const std::vector<Observation>& observations() const { return entries(); }
};

}  // namespace bearing_calibration::core
