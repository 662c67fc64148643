#pragma once

#include <cstdint>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/vision/detection.h"

namespace bearing_calibration::core {

/// How a light is told from others by its blinking. Parameter group `blink`.
struct BlinkConfig {
  bool use = false;
  double rate_hz = 0.0;   ///< whole periods of the light's brightness
  double window_s = 0.0;  ///< of the past that is judged
  /// Of a candidate's changes of brightness, the part that must be at the rate: 0.81 is all of an
  /// even on and off.
  double min_part_at_rate = 0.0;
  double max_turn_rate_radps =
      0.0;                    ///< of a bearing: how far a light moves between two observations
  std::int32_t light_id = 0;  ///< given to the light that blinks

  void declare(Parameters& params);
};

/// Tells the light that blinks at a known rate: follows every candidate by its azimuth, keeps its
/// brightness, 0 while it is not seen, and compares the changes with the rate.
class BlinkIdentifier {
 public:
  /// @throws std::invalid_argument with what errorsOf() says.
  explicit BlinkIdentifier(const BlinkConfig& config);

  /// Gives the light that blinks its light_id; all others get the probability 0: they are not the
  /// light, or not yet. Sets come in the order of their stamps, one for every image, empty ones
  /// too, and each image searched whole; an earlier stamp than the last begins anew.
  /// @param lights of the image, as the candidates of `set`
  /// @throws std::invalid_argument unless there is one for each candidate.
  void identify(const std::vector<Detection>& lights, BearingSet* set);

 private:
  struct Sample {
    Stamp stamp;
    double brightness;
  };
  struct Track {
    double azimuth_rad;  ///< when it was last seen
    Stamp seen;
    std::vector<Sample> samples;
    bool matched;
  };

  Track* trackOf(const Bearing& candidate, Stamp stamp);
  bool blinks(const Track& track) const;
  void forgetBefore(Stamp stamp);

  BlinkConfig config_;
  std::vector<Track> tracks_;
  Stamp last_stamp_;
};

}  // namespace bearing_calibration::core
