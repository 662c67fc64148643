#pragma once

#include <boost/circular_buffer.hpp>
#include <optional>

#include "bearing_calibration/common/stamp.h"
#include "bearing_calibration/odometry/odometry_increment.h"
#include "bearing_calibration/odometry/wheel_readings.h"

namespace bearing_calibration::core {

/// The wheels' travel over time, read out as the motion since an anchor: the moment of the last
/// fused bearing. The newest readings are kept one by one, so that a bearing that arrives late
/// finds its moment between two of them; older ones are folded into the motion since the anchor, so
/// that memory is bounded and no motion is lost however long no bearing comes.
class OdometryTrack {
 public:
  /// @param history  how far behind the newest reading a bearing may lie
  OdometryTrack(double wheel_separation_m, const WheelNoise& noise, Duration history);

  /// Appends a reading; its stamp must be later than the last one's. Leaves out the last one where
  /// the two show that it was stamped on a late arrival; its motion is in this one's.
  void add(const WheelTravel& travel);

  bool empty() const { return readings_.empty(); }
  Stamp oldest() const { return readings_.front().stamp; }
  Stamp newest() const { return readings_.back().stamp; }
  /// Whether `stamp` lies between two kept readings.
  bool covers(Stamp stamp) const;

  /// Motion from the anchor to `stamp`, which must be covered and not before the anchor. Without an
  /// anchor, no motion.
  OdometryIncrement motionTo(Stamp stamp) const;
  /// Travel around `stamp`, which must be covered. Before the oldest reading the wheels stand;
  /// after the newest one they keep their speed.
  OdometryWindow travelAround(Stamp stamp) const;
  /// Puts the anchor at `stamp`, which must be covered.
  void anchorAt(Stamp stamp);

 private:
  static constexpr std::size_t kMaxReadings = 1U << 15U;  ///< 1 MB; 32 s of a 1 kHz encoder
  static constexpr int kLeastIntervals = 10;              ///< before one of them is usual
  static constexpr int kMostIntervals = 100;              ///< in the running mean

  /// Whether the newest reading came late: `next` follows within half of the usual interval, though
  /// since the last kept one they have come no faster than at twice the usual rate.
  bool isNewestLate(Stamp next) const;
  void averageInterval(Stamp next);
  WheelTravel travelAt(Stamp stamp) const;
  OdometryIncrement appendTravel(const OdometryIncrement& increment, const WheelTravel& from,
                                 const WheelTravel& to) const;
  void foldOldest();

  double wheel_separation_m_;
  WheelNoise noise_;
  Duration history_;
  boost::circular_buffer<WheelTravel> readings_{kMaxReadings};
  std::optional<WheelTravel> anchor_;  ///< where motion is counted from
  OdometryIncrement folded_;           ///< motion from the original anchor to anchor_
  double usual_interval_s_ = 0.0;      ///< between readings, those left out too
  int intervals_ = 0;                  ///< in it
  int left_out_ = 0;                   ///< since the last but one of readings_
};

}  // namespace bearing_calibration::core
