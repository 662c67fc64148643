#pragma once

#include <string>

#include "bearing_calibration/init/initializer.h"

namespace bearing_calibration::core {

/// Whether the base has moved enough for a start, but in a way that cannot tell the mount.
bool isDegenerate(const StartAttempt& attempt);

/// Whether the base has moved enough for a start, but no mount explains what was seen.
bool doesNotFit(const StartAttempt& attempt);

/// What the driver should do so that the next attempt succeeds, and what is known least so far.
std::string adviceFor(const StartAttempt& attempt);

}  // namespace bearing_calibration::core
