#pragma once

#include <boost/circular_buffer.hpp>

namespace bearing_calibration::core {

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
