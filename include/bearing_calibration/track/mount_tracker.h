#pragma once

#include <optional>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/filter/paper_filter.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {

/// Parameter group `filter`.
struct FilterConfig {
  using Parametrisation = LiveFilter::Parametrisation;
  Parametrisation parametrisation = Parametrisation::kCartesian;
  double gate_probability = 0.0;  ///< a true bearing passes the chi-square gate with this one

  void declare(Parameters& params);
};

/// A distance from the sensor to the light, and how well it is known.
struct LightDistance {
  double mean_m = 0.0;
  double stddev_m = 0.0;
};

/// Places the light on the ray of one bearing, seen from a mount that is known to its covariance
/// (model.md, eq. 14). The start of a filter from an earlier mount, and of its light after its
/// track was lost.
CartesianEstimate placeLight(const MountEstimate& base_from_sensor, const LightDistance& distance,
                             double azimuth_rad, double azimuth_variance_rad2);

/// Forgets a part of what is known about the only light, and nothing about the mount: adds a
/// variance of `stddev_m` in every direction and of `stddev_rad` seen from the base across the line
/// of sight.
StateEstimate widenLight(StateEstimate estimate, double stddev_m, double stddev_rad);

/// The light as it was followed before it was looked for anew. Either a wheel has slipped, and this
/// is history; or the light was hidden for a while, another was taken for it, and it turns up where
/// the odometry says.
class FormerTrack {
 public:
  explicit FormerTrack(const LiveFilter& filter) : filter_(filter) {}

  void move(const OdometryIncrement& motion) { filter_.predict(motion); }

  /// An image at the end of the last motion.
  /// @param present  what it showed at the present place: what is seen at both tells nothing
  Association fuse(const std::vector<Bearing>& candidates, const OdometryWindow& nearby,
                   const FusionConfig& fusion, const Association& present);

  /// The last image and nearly all before it showed the light at its old place, and there only.
  bool isBack() const;
  /// It has not turned up for so long that it will not.
  bool isHistory() const;

  const LiveFilter& filter() const { return filter_; }

 private:
  LiveFilter filter_;
  unsigned found_ = 0;  ///< there only: a bit for each image, the last one's lowest
  int images_ = 0;
};

/// The filter at work: predicts by the base's motion, chooses the light among an image's
/// candidates, updates, and finds the light again after its track was lost.
class MountTracker {
 public:
  /// @param bearing_correlation  of one bearing's noise with the next one's, in [0, 1): n bearings
  ///   are then worth fewer, and their variances are widened for it
  MountTracker(const FilterConfig& config, const StateEstimate& start, double bearing_correlation);

  /// The base has moved; no image.
  void move(const OdometryIncrement& motion);
  /// An image at the end of the last motion: the filter takes the light in, if it is there.
  /// @param candidates  those that can be this light
  /// @param nearby  the travel around the image's stamp
  /// @param may_be_others  another light can be among them, or alone in the image: this one is
  ///   believed to be where the filter has it only
  Association fuse(const std::vector<Bearing>& candidates, const OdometryWindow& nearby,
                   bool may_be_others);

  /// Takes up what a better estimator says of the last image.
  void rebase(const StateEstimate& estimate, double bearing_correlation);

  const LiveFilter& filter() const { return filter_; }
  /// Where the light would be seen after a further motion.
  AzimuthPrediction predictAzimuthAfter(const OdometryIncrement& motion,
                                        const OdometryWindow& nearby) const;
  /// Whether the light may be elsewhere than the filter says: it was looked for anew not long ago,
  /// or the base has turned by an unknown angle since it was seen.
  bool isSearching() const { return former_.has_value() || motion_unknown_; }
  Consistency consistency() const { return recent_.consistency(); }
  /// Whether so little fits the estimate that it is better to start anew.
  bool isLost() const;

 private:
  Association placeAnew(const std::vector<Bearing>& candidates, bool may_be_others);
  void noteFused(const Association& association);
  void lookAnew();

  FusionConfig fusion_;
  LiveFilter filter_;
  std::optional<FormerTrack> former_;  ///< while the light may turn up at its old place
  bool motion_unknown_ = false;        ///< the light's direction is lost since the last update
  int gated_in_a_row_ = 0;
  RecentInnovations recent_;  ///< one of each image
};

}  // namespace bearing_calibration::core
