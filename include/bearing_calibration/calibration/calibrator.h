#pragma once

#include <map>
#include <memory>
#include <optional>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/fits_beside.h"
#include "bearing_calibration/common/input_outcome.h"
#include "bearing_calibration/judge/driver_advice.h"
#include "bearing_calibration/odometry/odometry_track.h"
#include "bearing_calibration/odometry/wheel_odometer.h"
#include "bearing_calibration/odometry/wheel_readings.h"
#include "bearing_calibration/optics/bearing.h"
#include "bearing_calibration/output/result.h"
#include "bearing_calibration/track/association_outcome.h"

namespace bearing_calibration::core {

/// The calibration of one sensor's mount: wheel readings and bearings in, the mount out. It checks
/// and counts what comes in, brings both streams into one order of time, and hands each image with
/// the motion before it to the estimation, once the ticks cover it and the reorder window behind
/// it; memory is bounded whatever stream stops. Reads no clock: `received` is the time of an
/// input's receipt. Not thread-safe, wherever its fits run.
class Calibrator {
 public:
  /// @throws std::invalid_argument with every sentence of errorsOf().
  explicit Calibrator(const CalibratorConfig& config, FitsRun fits_run = FitsRun::kAtOnce);

  InputOutcome addTicks(const WheelCounts& ticks, Stamp received);
  InputOutcome addAngles(const WheelAngles& angles, Stamp received);
  InputOutcome addOdometry(const OdometryPose& odometry, Stamp received);
  /// The counter of one wheel, where each has its own stream (see WheelPairing). The outcome is the
  /// first bad one of this reading and of those that it completes.
  InputOutcome addWheel(WheelSide side, const WheelCount& count, Stamp received);

  /// Bad candidates are left out one by one; the outcome is that of the message, or of the first
  /// bad candidate in it.
  InputOutcome addBearings(const BearingSet& bearings, Stamp received);

  /// Takes in the bearings that wait for more ticks than those that cover them: none will come.
  void finish();

  /// Where the light should be seen at `stamp` (sensor's clock), by the newest ticks at most; none
  /// before the first estimate.
  std::optional<BearingPrediction> predictBearing(Stamp stamp) const;

  CalibrationResult result() const;

  /// Takes over a fit that has ended beside, if there is one; the inputs do so, too.
  /// @throws what has ended a fit; from an input, too, which is taken in nevertheless
  void takeOverFit();
  /// All zero where fits are done at once.
  FitsReport fits() const { return estimation_->report(); }

  /// Where the newest wheel reading has the base; none before the first one.
  std::optional<BasePlace> place() const;

  /// Goes on from a mount that an earlier calibration has found, as long as the observations agree
  /// with it. To be called before the first input.
  void resume(const StateEstimate& earlier);

  /// Is told of every image in the order of time, from within the inputs; it must not call the
  /// calibrator. To be set before the first input.
  void observe(OutcomeObserver observer) { observer_ = std::move(observer); }

  /// Forgets everything but the configuration and the observer, the counts and what was taken up
  /// too. What is paused stays so: who has said that bearings mean nothing has not taken it back.
  void reset();
  /// While paused, ticks are followed and bearings are ignored.
  void setPaused(bool paused);
  bool isPaused() const { return paused_; }

 private:
  Calibrator(const CalibratorConfig& config, std::unique_ptr<FitsBeside> estimation);

  template <class Reading>
  InputOutcome addReading(const Reading& reading, Stamp received);
  InputOutcome pair(WheelSide side, const WheelCount& count, Stamp received);
  InputOutcome accept(const BearingSet& bearings, Stamp received);
  InputOutcome judgeGeometry(const SensorGeometry& stated) const;
  bool isAnother(const SensorGeometry& stated) const;
  InputOutcome assume(const SensorGeometry& stated);
  void noteStepBack();
  InputOutcome countBearings(const InputOutcome& outcome);
  InputOutcome afterwards(const InputOutcome& outcome) {
    takeOverFit();
    return outcome;
  }
  void followTravel(const WheelTravel& travel);
  std::optional<Frame> nextCovered(double reorder_window_s);
  void processCovered(double reorder_window_s);

  CalibratorConfig config_;
  SensorGeometry assumed_;  ///< that of config_, or what the sensor states
  WheelPairing pairing_;
  WheelOdometer odometer_;
  OdometryTrack track_;
  std::multimap<Stamp, BearingSet> waiting_;  ///< for the ticks that cover them
  std::unique_ptr<FitsBeside> estimation_;
  std::optional<StateEstimate> earlier_;
  std::optional<WheelTravel> last_travel_;
  std::optional<Stamp> last_fused_;  ///< on the encoders' clock
  /// The encoders' clock has stepped back from here: what is stamped earlier may be of either time.
  std::optional<Stamp> passed_twice_;
  Pose2 start_from_fused_;  ///< the base at that moment, in its frame at the first one
  TimeInView in_view_;
  bool paused_ = false;
  OutcomeObserver observer_;  ///< may be empty
  CalibrationResult counts_;  ///< only what is counted up here
};

}  // namespace bearing_calibration::core
