#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/record/record_beginning.h"
#include "bearing_calibration/solve/slip_hypotheses.h"

namespace bearing_calibration::core {

/// The batch over one light's record as it grows: each fit begins where the last one settled. Since
/// then the filter may have followed something else.
class RecordFit {
 public:
  explicit RecordFit(const InitializerConfig& config) : config_(config), batch_(config.batch) {}

  /// Where the next fit begins.
  /// @param start  at one of `observations`
  void beginAt(const RecordStart& start, const std::vector<Observation>& observations);

  /// @param running  at the last observation: where it begins without success from there
  /// @param beginning  of the record, unless it is whole
  /// @returns none when it does not settle
  std::optional<SlipAverage> fit(const std::vector<Observation>& observations,
                                 const StateEstimate& running,
                                 const std::optional<RecordBeginning>& beginning);

  /// How many of the record's oldest observations are to be given away: none while a rival is open.
  /// @param settled  the last fit
  /// @param most  of its observations
  static std::size_t cutOf(const SlipAverage& settled, std::size_t most);
  /// What they say. So much is weighed with hindsight.
  /// @param observations,fit  all of them, and SlipAverage::trusting
  /// @param count  of those, by cutOf()
  /// @param average  of what the fit says of them, over all noise; none where that is known
  RecordPart oldestPart(const std::vector<Observation>& observations, const BatchEstimate& fit,
                        std::size_t count, const std::optional<StateEstimate>& average) const;

 private:
  BatchEstimate fitOnce(const std::vector<Observation>& observations, const StateEstimate& running,
                        const std::optional<RecordBeginning>& beginning) const;
  RivalMount otherMinimum(const std::vector<Observation>& observations,
                          const SlipAverage& settled) const;

  InitializerConfig config_;
  BatchEstimator batch_;
  struct Settled {
    Stamp stamp;        ///< of the observation
    RecordStart start;  ///< there; `observation` as the record was then
  };
  std::optional<Settled> settled_;  ///< the last fit
  RivalMount other_minimum_;        ///< of the record while it was whole
};

}  // namespace bearing_calibration::core
