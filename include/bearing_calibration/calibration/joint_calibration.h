#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "bearing_calibration/calibration/config.h"
#include "bearing_calibration/calibration/joint_record.h"
#include "bearing_calibration/calibration/schedule.h"
#include "bearing_calibration/filter/lasting_estimate.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "bearing_calibration/record/lights_record.h"
#include "bearing_calibration/track/association.h"

namespace bearing_calibration::core {

/// The mount that several lights tell together. The wheels' noise is shared, so that their own
/// answers must not just be averaged: a filter of all lights at once takes every bearing that a
/// light's own calibration has taken, and is begun anew from a fit of the record, as that of one
/// light is. A full record gives its oldest part away, for mount and lights together.
class JointCalibration {
 public:
  explicit JointCalibration(const CalibratorConfig& config);

  /// An image with the bearings that the lights' own calibrations took, after a motion.
  void add(const LightsImage& image);
  /// Nothing that was seen of a light so far counts any longer.
  void forget(std::size_t light);

  /// Where its record begins, when it has given something away; else the least stamp.
  Stamp since() const { return record_.beginning() ? record_.entries().front().stamp : Stamp(); }

  /// Whether the last image is one to fit the record at.
  bool isReviewDue() const { return is_review_due_; }
  /// Fits the record anew.
  /// @param answers  for each light, its own one; null for those that may not take part
  /// @param lights_in_base  where each of them is at the last image
  /// @param earlier  what an earlier calibration has found
  void review(const std::vector<const LandmarkSolution*>& answers,
              const LightPositions& lights_in_base, const std::optional<StateEstimate>& earlier);

  /// At the last image; none while fewer than two lights agree.
  struct Joint {
    LiveFilter filter;
    std::vector<std::size_t> lights;  ///< which ones, in the order of the filter's
    Judgement judgement;
    RecentInnovations recent;  ///< of all its lights
  };
  const std::optional<Joint>& joint() const { return joint_; }
  /// Lights that the last review left out, because they say another mount than the others.
  const std::vector<std::size_t>& contradicting() const { return contradicting_; }
  enum class Outcome : std::uint8_t {
    kTooFew,  ///< fewer than two lights to be held against each other
    kTorn,    ///< they contradict each other, and nobody knows which one is right
    kUnfit,   ///< they agree, but nothing fits all of their bearings
    kJoint,
  };
  /// Of the last review.
  Outcome outcome() const { return outcome_; }

 private:
  Outcome fitTogether(const std::vector<const LandmarkSolution*>& answers,
                      const std::vector<std::size_t>& lights);
  bool isInRecord(std::size_t light) const;
  std::optional<RecordBeginning> beginningOf(const std::vector<std::size_t>& lights) const;
  std::optional<RecordPart> oldestPart(const std::vector<Observation>& observations,
                                       const BatchEstimate& fit, std::size_t lights) const;
  double contradictionOf(const LandmarkSolution& answer) const;
  std::optional<std::size_t> oneTooMany(const std::vector<const LandmarkSolution*>& answers,
                                        const std::vector<std::size_t>& lights);
  std::size_t mostContradicted(const std::vector<const LandmarkSolution*>& answers) const;
  Judgement judge(const StateEstimate& estimate, bool is_clear);

  CalibratorConfig config_;
  LightsRecord record_;
  Schedule reviews_;
  bool is_review_due_ = false;
  OdometryIncrement motion_since_record_;
  std::optional<Joint> joint_;
  LightPositions lights_in_base_;               ///< at the last review, of all lights
  std::optional<RecordPart> oldest_;            ///< what the last fit would give away
  std::vector<std::size_t> lights_given_away_;  ///< those that the record's beginning knows
  std::vector<NoiseLevels> noise_;              ///< of joint_'s lights, widened where correlated
  NoiseLevels wheel_noise_;                     ///< of the motions
  std::vector<std::size_t> contradicting_;
  Outcome outcome_ = Outcome::kTooFew;
  ClaimedMount claimed_;
};

}  // namespace bearing_calibration::core
