#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/solve/batch_estimator.h"

namespace bearing_calibration::core {

/// Natural logarithms of the bearings' and the wheels' factor; logits of the share of the bearings'
/// variance that lasts into the next bearing, and of how much of it does.
enum NoiseIndex : int {
  kBearingLevel,
  kWheelLevel,
  kLastingShare,
  kLasting,
  kLightSize,
  kNoiseUnknowns
};
using NoiseUnknowns = Eigen::Matrix<double, kNoiseUnknowns, 1>;
using NoiseUnknownsMatrix = Eigen::Matrix<double, kNoiseUnknowns, kNoiseUnknowns>;

/// What innovations tell of the unknowns, as a normal distribution that may be improper.
struct NoiseInformation {
  NoiseUnknownsMatrix matrix = NoiseUnknownsMatrix::Zero();
  NoiseUnknowns times_mean = NoiseUnknowns::Zero();  ///< the matrix times the likeliest unknowns

  /// As so large a share of what told `other` is given away: never more than a whole record tells,
  /// because noise changes on the way.
  void give(double share, const NoiseInformation& other) {
    matrix += share * (other.matrix - matrix);
    times_mean += share * (other.times_mean - times_mean);
  }
};

/// Innovations of a record, and what it says of the robot in the end.
struct FilteredRecord {
  std::vector<Innovation> innovations;
  StateEstimate last;
};

/// A record, linearised about the path of its fit, with the bearings' noise as a state of its own:
/// a first-order autoregression. A filter's pass for any levels of noise is cheap.
class NoiseRecord {
 public:
  NoiseRecord(const std::vector<Observation>& observations, const BatchEstimate& fit,
              const ErrorPriors& errors);

  std::size_t size() const { return steps_.size(); }  ///< observations

  /// @param gives_up_slips  that the fit gave up; else their motions are as good as all others
  /// @param count  of the observations, from the first one on
  FilteredRecord filter(const NoiseUnknowns& unknowns, bool gives_up_slips,
                        std::size_t count) const;

 private:
  struct Step {
    LinearMotion motion;  ///< with the stated noise
    StateVector path;
    StateRow H;
    double residual_rad;  ///< at the path
    double stddev_rad;    ///< as stated
    double range_m;       ///< to the light
    double intervals;     ///< since the observation before it
    bool moves, has_unseen, slipped, use_bearing;
    struct Elevation {
      StateRow H;
      double residual_rad;
      double variance_rad2;
    };
    std::optional<Elevation> elevation;  ///< where it tells anything that is looked for
  };

  StateEstimate before_;
  std::vector<Step> steps_;
};

}  // namespace bearing_calibration::core
