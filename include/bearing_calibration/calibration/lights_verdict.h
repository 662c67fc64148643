#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "bearing_calibration/calibration/joint_calibration.h"
#include "bearing_calibration/calibration/landmark.h"
#include "bearing_calibration/output/result.h"

namespace bearing_calibration::core {

/// What several lights, each for itself and all together, say of the mount. Refers to them.
class LightsVerdict {
 public:
  /// @param mount_moved  what they agree on about a mount that has moved
  LightsVerdict(const std::vector<Landmark>& lights, const JointCalibration& joint,
                const std::optional<Judgement>& mount_moved)
      : lights_(lights), joint_(joint), mount_moved_(mount_moved) {}

  /// Fills in state, advice, estimates, consistency, counts of bearings, and all lights.
  void describe(CalibrationResult* result) const;

 private:
  std::size_t leader() const;
  std::optional<Judgement> objection() const;
  std::string noteOn(std::size_t light) const;
  std::vector<LightSummary> summarise(std::size_t leading, CalibrationResult* result) const;
  void takeJoint(CalibrationResult* result) const;

  const std::vector<Landmark>& lights_;
  const JointCalibration& joint_;
  const std::optional<Judgement>& mount_moved_;
};

}  // namespace bearing_calibration::core
