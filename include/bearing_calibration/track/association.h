#pragma once

#include <boost/circular_buffer.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/filter/live_filter.h"
#include "bearing_calibration/optics/bearing.h"

namespace bearing_calibration::core {

/// Which of an image's candidates is the light.
struct Association {
  enum class Kind : std::uint8_t {
    kNothingSeen,  ///< no candidate
    kGated,        ///< none inside the gate
    kAmbiguous,    ///< two that could be the light about equally well
    kFound,
  };
  Kind kind = Kind::kNothingSeen;
  std::size_t candidate = 0;        ///< kFound: its position in the list
  Innovation innovation{0.0, 0.0};  ///< of the nearest candidate, unless nothing was seen
};

/// The candidate nearest to the prediction by its NIS, when it passes the gate and no other is
/// nearly as likely.
/// @param gate  largest NIS that passes
Association associate(const AzimuthPrediction& prediction, const std::vector<Bearing>& candidates,
                      double gate);

/// How an image's light updates a filter.
struct FusionConfig {
  double gate = 0.0;      ///< largest NIS that passes
  double widening = 1.0;  ///< of the bearings' variances, for their correlation

  Bearing widened(Bearing light) const {
    light.azimuth_variance_rad2 *= widening;
    return light;
  }
};

/// Whether a bearing is where a light is expected: within four standard deviations.
bool isWhereExpected(const AzimuthPrediction& light, const Bearing& candidate);

/// The turn of the base [rad] that its wheels do not show, because they have slipped: it takes
/// several lights that nobody has numbered off from where they are expected, all by the same angle.
/// None where most are where they are expected, where no such turn explains them, or more than one.
/// @param expected  azimuths of the lights
std::optional<double> hiddenTurn(const std::vector<AzimuthPrediction>& expected,
                                 const std::vector<Bearing>& candidates);

/// What a filter made of the latest bearings.
struct Consistency {
  double nis = 0.0;       ///< of the last fused bearing
  double nis_mean = 0.0;  ///< over those of the latest that were fused; 0 before the first
  int fused = 0;          ///< of the latest bearings
  int not_fused = 0;      ///< of the latest bearings: seen, but gated or ambiguous
};

/// The latest bearings that a filter was offered.
class RecentInnovations {
 public:
  static constexpr int kWindow = 100;  ///< bearings that it looks back over

  RecentInnovations() : nis_(kWindow) {}

  void noteFused(double nis) { nis_.push_back(nis); }
  void noteNotFused() { nis_.push_back(kNotFused); }
  Consistency consistency() const;

 private:
  static constexpr double kNotFused = -1.0;

  boost::circular_buffer<double> nis_;
};

}  // namespace bearing_calibration::core
