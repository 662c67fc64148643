#pragma once

#include <vector>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {

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

}  // namespace bearing_calibration::core
