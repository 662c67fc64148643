#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/filter/observation.h"
#include "bearing_calibration/record/observation_path.h"

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

/// A number with its standard deviation.
struct MeasuredNumber {
  double value = 0.0;
  double stddev = 0.0;
};

/// Bearings of a robot that turns on the spot, where a light seems to turn as the wheels say, the
/// other way round, but for a Fourier series: a sensor off the axis, or a mirror that leans.
struct TurningBearings {
  int bearings = 0;
  double turn_rad = 0.0;       ///< in all, either way
  double stddev_rad = 0.0;     ///< as they scatter about that
  MeasuredNumber late_s;       ///< stamps against the wheels'
  MeasuredNumber more_turn;    ///< true turn over what the wheels say, less 1
  bool tells_latency = false;  ///< the rate of turn changes enough
};

struct SensorCheck {
  std::optional<StandingBearings> standing;  ///< none without some seconds of it
  std::optional<TurningBearings> turning;    ///< none without a whole turn
};

/// @param observations  of one light, as stated
SensorCheck checkSensor(const std::vector<Observation>& observations);
/// Its second part.
std::optional<TurningBearings> checkTurning(const std::vector<Observation>& observations);

/// The same as sentences, and what to drive where something is missing.
std::vector<std::string> inWords(const SensorCheck& check);

/// All longest stretches in each of which `belongs(i)` holds from the second observation on, and
/// nothing is missing for long: a bag may hold two recordings.
template <class Belongs>
std::vector<Stretch> stretchesOf(const std::vector<Observation>& observations,
                                 const Belongs& belongs) {
  constexpr Duration kLongestGap = std::chrono::seconds(5);
  std::vector<Stretch> stretches;
  Stretch now;
  for (std::size_t i = 1; i <= observations.size(); ++i) {
    now.end = i;
    const bool goes_on =
        i < observations.size() && observations[i].stamp - observations[i - 1].stamp <= kLongestGap;
    if (goes_on && belongs(i)) continue;
    if (now.size() > 1) stretches.push_back(now);
    now.begin = i;
  }
  return stretches;
}

}  // namespace bearing_calibration::core
