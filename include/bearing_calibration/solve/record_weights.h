#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "bearing_calibration/solve/batch_estimator.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {

/// Whether a moment is so near to a slip that its motion is not believed either: a slip lasts, and
/// what is found is its most telling moment.
bool isNearSlip(Stamp moment, Stamp slip);

/// Time from one image to the next, as it mostly is [s]; 0 with fewer than two.
double usualInterval(const std::vector<Observation>& observations);

/// How much each bearing and each motion of a record is believed, while a batch fit goes on:
/// Huber's weights first, plain ones without the outliers at the end; motions that slipped;
/// variances widened for correlated noise. `observations` and `config` must outlive it.
class RecordWeights {
 public:
  /// @param is_plausible  of each observation: false for one that is set aside from the outset
  RecordWeights(const std::vector<Observation>& observations, const std::vector<bool>& is_plausible,
                const BatchConfig& config, const SlipHypothesis& slips);

  const std::vector<ObservationWeight>& observations() const { return weights_; }
  const std::vector<std::size_t>& slips() const { return slips_; }
  /// Of neighbouring bearings of one light: the largest.
  double correlation() const { return correlation_; }

  /// Huber's weights by the residuals along `path`, or plain ones where Huber is off or over.
  void weighBearings(const RecordPath& path);
  /// From now on all bearings in use count in full.
  void endHuber(const RecordPath& path);
  /// Decides anew which observations are left out; true when that changed.
  bool rejectOutliers(const SmootherPass& pass);
  /// Gives up the motion that the bearings contradict most; true when they do so clearly.
  bool giveUpSlip(const SmootherPass& pass);
  /// Widens the variances of bearings and elevations whose neighbouring innovations are correlated:
  /// then true.
  bool widenForCorrelation(const SmootherPass& pass, const RecordPath& path);

  /// Cost of the bearings in use along `path`, Huber's or the plain one.
  double bearingCost(const RecordPath& path) const;
  /// What the observations left out and the motions given up cost: what they would cost at their
  /// limits.
  double costOfDisbelief(const RecordPath& path) const;

 private:
  double sigmas(std::size_t i, const RecordPath& path) const;
  double elevationSigmas(std::size_t i, const RecordPath& path) const;
  double azimuthVariance(std::size_t i, const RecordPath& path) const;
  bool isInsideSlip(std::size_t i) const;
  bool mayBeLight(std::size_t i, const RecordPath& path) const;
  bool isNear(std::size_t i, std::size_t slip) const;
  double slipCost(std::size_t i) const;  ///< of giving up the motion to this observation
  void giveUp(std::size_t slip);

  const std::vector<Observation>& records_;
  const BatchConfig& config_;
  double usual_interval_s_;
  std::vector<ObservationWeight> weights_;
  std::vector<std::size_t> next_image_;  ///< of each observation: where the next image begins
  SlipHypothesis supposed_;
  std::vector<std::size_t> slips_;
  bool huber_;
  std::array<double, kMostLights> widening_;  ///< of each light's bearing variances
  std::array<double, kMostLights> elevation_widening_;
  double correlation_ = 0.0;
  int rejection_rounds_ = 0;
};

/// n measurements whose noise is a first-order autoregression are worth this times fewer white
/// ones.
double wideningFor(double correlation);

}  // namespace bearing_calibration::core
