#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "bearing_calibration/calibration/mount_calibration.h"
#include "bearing_calibration/filter/lasting_estimate.h"

namespace bearing_calibration::core {

/// One light among several: its own calibration, and what the others may make of it.
class Landmark {
 public:
  Landmark(const CalibratorConfig& config, FitsRun fits_run) : calibration_(config, fits_run) {}

  void resume(const StateEstimate& earlier) { calibration_.resume(earlier); }
  AssociationOutcome process(const BearingSet& image, const OdometryIncrement& motion,
                             const OdometryWindow& nearby);

  bool isWorkDue() const { return calibration_.isWorkDue(); }
  void work() { calibration_.work(); }

  /// See MountCalibration::shareSince().
  void shareSince(Stamp stamp) { calibration_.shareSince(stamp); }

  /// Looks at what its calibration has made of itself since the last time.
  /// @param way_m  of the robot so far, turns included
  void review(double way_m);

  const MountCalibration& calibration() const { return calibration_; }
  std::int32_t lightId() const { return calibration_.lightId(); }
  /// Its calibration carries on from a start.
  bool isFound() const { return calibration_.judgement() != nullptr; }
  /// Its own answer has stood for as long as a verdict on it alone would have to: all that makes
  /// such a verdict honest, but for how well the mount is known.
  bool isSound() const { return is_sound_; }
  bool saysMountMoved() const {
    return isFound() && calibration_.judgement()->cause == Fault::kMountMoved;
  }
  /// Since when it has said that the mount has moved [m].
  double saysSoFor(double way_m) const { return way_m - mount_moved_m_.value_or(way_m); }
  Stamp lastSeen() const { return last_seen_; }
  /// Why it does not take part; empty when nothing speaks against it.
  std::string obstacle() const;

 private:
  void forget();

  MountCalibration calibration_;
  Stamp last_seen_;
  Stamp answered_;  ///< end of the record of the last answer that was looked at
  std::optional<double> one_mount_since_m_;
  bool is_sound_ = false;
  std::optional<double> mount_moved_m_;  ///< since when it says so
};

/// "light 7", or "light number 1" of one whose own number nobody knows.
/// @param place  among all lights
std::string nameOf(const Landmark& light, std::size_t place);

}  // namespace bearing_calibration::core
