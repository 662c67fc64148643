#pragma once

#include <optional>
#include <string>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/init/initializer.h"
#include "bearing_calibration/optics/field_of_view.h"

namespace bearing_calibration::core {

/// Whether the base has moved enough for a start, but in a way that cannot tell the mount.
bool isDegenerate(const StartAttempt& attempt);

/// Whether the base has moved enough for a start, but no mount explains what was seen.
bool doesNotFit(const StartAttempt& attempt);

/// What the driver should do so that the next attempt succeeds, and what is known least so far.
std::string adviceFor(const StartAttempt& attempt);

/// How much of the time a sensor that sees a part of a turn only sees the light, of late.
class TimeInView {
 public:
  /// An image, with the light or without it.
  void add(const FieldOfView& view, Stamp stamp, bool is_seen);
  /// `advice` for the driver, and before it to keep the light in view, where it is seen more rarely
  /// than by a robot that heads anywhere.
  std::string adviceWith(const std::string& advice) const;

 private:
  FieldOfView view_;
  std::optional<Stamp> last_;
  double watched_s_ = 0.0;  ///< what is long ago counts less
  double seen_s_ = 0.0;     ///< ... with the light
};

}  // namespace bearing_calibration::core
