#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/joint_calibration.h"
#include "bearing_calibration/calibration/mount_calibration.h"

namespace bearing_calibration::core {

/// What a displacement of the mount by 3 degrees takes the lights in view to notice (faults.md).
/// After so much way a light that alone says so has moved itself; those that were not seen for as
/// long are no witnesses.
inline constexpr double kNoticedWithin_m = 10.0;

/// The calibration of one mount with up to CalibratorConfig::max_lights lights. Each light has a
/// calibration of its own, with all that makes that one robust and honest; together they make a
/// joint one (model.md). With one light at most it is that light's calibration and nothing
/// else. A value: a copy goes on by itself.
class SeveralLights {
 public:
  /// @param fits_run  kBeside: process() leaves what is heavy to work()
  explicit SeveralLights(const CalibratorConfig& config, FitsRun fits_run = FitsRun::kAtOnce);

  /// Goes on from a mount that an earlier calibration has found. To be called before the first
  /// image.
  void resume(const StateEstimate& earlier);

  /// @returns what became of an image in the calibration of the first light
  AssociationOutcome process(const Frame& frame);

  /// Whether the last image that showed one of the lights has this stamp.
  bool isAnySeenAt(Stamp stamp) const;
  /// Whether the last image has made heavy work due that is not done.
  bool isWorkDue() const;
  /// Does it. To be called before the next image only: what fits say is of the last one.
  void work();
  /// How often process() has given up all that it had of a light that was found.
  int newStarts() const { return new_starts_; }

  /// Where the light would be seen; none where there are several: all of the image is looked at.
  std::optional<AzimuthPrediction> predictAzimuthAfter(const OdometryIncrement& motion,
                                                       const OdometryWindow& nearby) const;
  std::int32_t lightId() const;

  /// Fills in what the lights, each for itself and all together, say of the mount.
  void describe(CalibrationResult* result) const;

 private:
  bool isMany() const { return config_.max_lights > 1; }
  MountCalibration newLight() const;
  OdometryIncrement withHiddenTurn(const Frame& frame) const;
  bool isOwned(std::int32_t light_id) const;
  using Expected = std::vector<std::optional<AzimuthPrediction>>;  ///< of each light
  Expected expectedIn(const Frame& frame) const;
  bool mayBeOf(std::size_t light, const Bearing& candidate, const Expected& expected) const;
  bool isOffered(const Bearing& candidate, std::size_t light, const Expected& expected) const;
  std::vector<Bearing> offeredTo(std::size_t light, const std::vector<Bearing>& left,
                                 const Expected& expected) const;
  void take(std::size_t light, const AssociationOutcome& outcome, std::vector<Bearing>* left,
            LightsImage* seen);
  void welcome(Frame frame, std::vector<Bearing>* left, LightsImage* seen);
  std::optional<std::size_t> placeForAnother(Stamp now) const;
  void review();
  std::optional<Judgement> agreeOnMountMoved() const;
  void startAnew();
  std::string nameOf(std::size_t light) const;
  bool isOfLightsInView(const CalibrationResult& result) const;
  std::optional<Judgement> objectionTo(const CalibrationResult& result) const;
  bool isContradicting(std::size_t light) const;
  std::string noteOn(std::size_t light) const;
  void summarise(CalibrationResult* result) const;
  void takeJoint(CalibrationResult* result) const;

  CalibratorConfig config_;
  FitsRun fits_run_;
  int new_starts_ = 0;
  std::optional<StateEstimate> earlier_;
  std::vector<MountCalibration> lights_;
  bool is_ambiguous_ = false;  ///< the last image: a candidate may be more than one light
  JointCalibration joint_;
  std::optional<Judgement> mount_moved_;  ///< what the lights say of a mount that has moved
  bool restarted_ = false;                ///< because it had
};

}  // namespace bearing_calibration::core
