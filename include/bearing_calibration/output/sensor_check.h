#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/output/turning_bearings.h"

// What a bearing sensor shows of itself while its robot stands, and while it turns on the spot: no
// mount and no light need to be known.

namespace bearing_calibration::core {

/// Bearings of a robot that stands.
struct StandingBearings {
  int stops = 0;  ///< of a second at least
  int bearings = 0;
  double duration_s = 0.0;
  double stddev_rad = 0.0;          ///< as they scatter about each stop's mean
  double stated_stddev_rad = 0.0;   ///< as their sensor states it (root mean square)
  double correlation_time_s = 0.0;  ///< in which their correlation falls to 1/e; 0: none to be seen
  double outlier_share = 0.0;       ///< beyond five standard deviations, and in none of the above
};

struct SensorCheck {
  std::optional<StandingBearings> standing;  ///< none without some seconds of it
  std::optional<TurningBearings> turning;    ///< none without a whole turn
};

/// @param observations  of one light, as stated
SensorCheck checkSensor(const std::vector<Observation>& observations);

/// The same as sentences, and what to drive where something is missing.
std::vector<std::string> inWords(const SensorCheck& check);

}  // namespace bearing_calibration::core
