#include "bearing_calibration/output/offline_report.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/solve/slip_hypotheses.h"

namespace bearing_calibration::core {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// An hour at 10 Hz before the first observation is thinned out.
constexpr std::size_t kCapacity = 36000;

ObservationRecordConfig wideRecord(ObservationRecordConfig config) {
  config.capacity = std::max(config.capacity, kCapacity);
  return config;
}

/// The state after a motion of the base: the light moves against it.
Vector5 moved(const Vector5& state, const Pose2& start_from_end) {
  Vector5 after = state;
  after.head<2>() = start_from_end.inverse() * Eigen::Vector2d(state.head<2>());
  return after;
}

/// Goes through the looks beside the observations that were kept of them, and the batch's path at
/// these.
class Walk {
 public:
  Walk(const std::vector<Observation>& observations, const BatchEstimate& batch)
      : observations_(observations), batch_(batch) {}

  ReviewedImage review(const AssociationOutcome& outcome) {
    ReviewedImage reviewed;
    reviewed.outcome = outcome;
    if (!is_first_) {
      distance_m_ += outcome.observation.motion.distance_m;
      since_kept_ = append(since_kept_, outcome.observation.motion);
    }
    is_first_ = false;
    const bool kept =
        next_ < observations_.size() && observations_[next_].stamp == outcome.observation.stamp;
    if (kept) takeKept();
    reviewed.distance_m = distance_m_;
    reviewed.first_from_base = first_from_kept_ * corrected(since_kept_);
    reviewed.verdict = verdictOf(outcome, kept);
    reviewed.residual_rad = residualOf(outcome);
    reviewed.nis = reviewed.verdict == Verdict::kUsed ? batch_.nis[next_ - 1] : kNone;
    return reviewed;
  }

 private:
  bool isJudged() const { return !batch_.path.points.empty(); }

  Pose2 corrected(const OdometryIncrement& motion) const {
    return correctMotion(motion, batch_.path.errors).start_from_end;
  }

  void takeKept() {
    Pose2 motion = corrected(since_kept_);
    if (isJudged() && next_ > 0) {
      const Eigen::Vector3d& error = batch_.path.points[next_].motion_error;
      motion.position_m += error.head<2>();
      motion.yaw_rad = wrapAngle(motion.yaw_rad + error.z());
    }
    first_from_kept_ = first_from_kept_ * motion;
    since_kept_ = {};
    ++next_;
  }

  Verdict verdictOf(const AssociationOutcome& outcome, bool kept) const {
    if (outcome.kind == Association::Kind::kNothingSeen) return Verdict::kNothingSeen;
    if (!isJudged()) return Verdict::kUnjudged;
    if (!kept) return Verdict::kThinned;
    const auto& rejected = batch_.rejected;
    const bool is_left_out =
        std::find(rejected.begin(), rejected.end(), next_ - 1) != rejected.end();
    return is_left_out ? Verdict::kLeftOut : Verdict::kUsed;
  }

  double residualOf(const AssociationOutcome& outcome) const {
    if (!isJudged() || next_ == 0 || outcome.kind == Association::Kind::kNothingSeen) return kNone;
    const Vector5 state = moved(batch_.path.state(next_ - 1), corrected(since_kept_));
    return ::bearing_calibration::core::residualOf(outcome.observation, state, batch_.path.errors);
  }

  const std::vector<Observation>& observations_;
  const BatchEstimate& batch_;
  std::size_t next_ = 0;  ///< observation that has not been passed yet
  bool is_first_ = true;
  double distance_m_ = 0.0;
  Pose2 first_from_kept_;         ///< at the last observation that was passed
  OdometryIncrement since_kept_;  ///< motion since then
};

/// Every bearing, with the motion since the one before it.
std::vector<Observation> bearingsOf(const std::vector<AssociationOutcome>& outcomes) {
  std::vector<Observation> bearings;
  OdometryIncrement motion;
  for (const AssociationOutcome& outcome : outcomes) {
    motion = append(motion, outcome.observation.motion);
    if (outcome.kind == Association::Kind::kNothingSeen) continue;
    bearings.push_back(outcome.observation);
    bearings.back().motion = std::exchange(motion, {});
  }
  return bearings;
}

/// Mount and light of the first light, the one whose images are reviewed.
std::optional<CartesianEstimate> lightOf(const CalibrationResult& result) {
  return result.lights.empty() ? std::nullopt : result.lights.front().cartesian_state;
}

}  // namespace

const char* nameOf(Verdict verdict) {
  static const char* const kNames[] = {"nothing seen", "used", "left out", "thinned", "unjudged"};
  return kNames[static_cast<int>(verdict)];
}

OfflineReport::OfflineReport(const InitializerConfig& config)
    : config_(config), record_(wideRecord(config.record)) {}

void OfflineReport::add(const AssociationOutcome& outcome) {
  if (outcome.lost_light) {
    outcomes_.clear();
    record_.clear();
    motion_since_observation_ = {};
  }
  outcomes_.push_back(outcome);
  motion_since_observation_ = append(motion_since_observation_, outcome.observation.motion);
  if (outcome.kind == Association::Kind::kNothingSeen) return;
  Observation observation = outcome.observation;
  observation.motion = motion_since_observation_;
  record_.add(observation);
  motion_since_observation_ = {};
}

Review OfflineReport::conclude(const CalibrationResult& result) const {
  BatchConfig config = config_.batch;
  config.errors = result.error_priors;
  const std::vector<Observation> observations = withNoise(record_.observations(), result.noise);
  Review review;
  review.motion = summariseMotion(observations);
  review.sensor = checkSensor(bearingsOf(outcomes_));
  BatchEstimate fit;
  if (const auto& running = lightOf(result); running && !observations.empty()) {
    // it is at the last image, which may have shown nothing
    const Vector5 at_last_observation =
        moved(running->mean, motion_since_observation_.start_from_end.inverse());
    fit = BatchEstimator(config).estimate(
        observations, {at_last_observation, observations.size() - 1, result.robot_errors.mean});
    review.settled = fit.hasSettled(config_.min_inlier_fraction);
  }
  if (review.settled) {
    fit = averageOverSlips(observations, fit, config).best;
    review.slips = static_cast<int>(fit.slips.size());
    review.correlation = fit.correlation;
  } else {
    fit = {};
  }
  Walk walk(observations, fit);
  review.images.reserve(outcomes_.size());
  for (const AssociationOutcome& outcome : outcomes_) review.images.push_back(walk.review(outcome));
  return review;
}

}  // namespace bearing_calibration::core
