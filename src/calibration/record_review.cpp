#include "bearing_calibration/calibration/record_review.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/robot_errors.h"

namespace bearing_calibration {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A quarter of an hour at 10 Hz before the first sight is thinned out. The batch takes about a
/// second for so many, and their noise is correlated anyway.
constexpr std::size_t kCapacity = 10000;

SightRecordConfig wideRecord(SightRecordConfig config) {
  config.capacity = std::max(config.capacity, kCapacity);
  return config;
}

/// The state after a motion of the base: the light moves against it.
Vector5 moved(const Vector5& state, const Pose2& start_from_end) {
  Vector5 after = state;
  after.head<2>() = start_from_end.inverse() * Eigen::Vector2d(state.head<2>());
  return after;
}

/// Goes through the looks beside the sights that were kept of them, and the batch's path at these.
class Walk {
 public:
  Walk(const std::vector<Sight>& sights, const BatchEstimate& batch)
      : sights_(sights), batch_(batch), left_out_(sights.size(), false) {
    for (std::size_t rejected : batch.rejected) left_out_[rejected] = true;
  }

  ReviewedLook review(const Look& look) {
    ReviewedLook reviewed;
    reviewed.look = look;
    distance_m_ += is_first_ ? 0.0 : look.sight.motion.distance_m;
    if (!is_first_) since_kept_ = append(since_kept_, look.sight.motion);
    is_first_ = false;
    const bool kept = next_ < sights_.size() && sights_[next_].stamp == look.sight.stamp;
    if (kept) takeKept();
    reviewed.distance_m = distance_m_;
    reviewed.first_from_base = first_from_kept_ * corrected(since_kept_);
    reviewed.verdict = verdictOf(look, kept);
    reviewed.residual_rad = residualOf(look);
    reviewed.nis = reviewed.verdict == Verdict::kUsed ? batch_.nis[next_ - 1] : kNone;
    return reviewed;
  }

 private:
  bool isJudged() const { return !batch_.path.points.empty(); }

  Pose2 corrected(const OdometryIncrement& motion) const {
    return correctMotion<kErrorCount>(motion, batch_.errors.mean).start_from_end;
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

  Verdict verdictOf(const Look& look, bool kept) const {
    if (look.kind == Look::Kind::kNothingSeen) return Verdict::kNothingSeen;
    if (!isJudged()) return Verdict::kUnjudged;
    if (!kept) return Verdict::kThinned;
    return left_out_[next_ - 1] ? Verdict::kLeftOut : Verdict::kUsed;
  }

  double residualOf(const Look& look) const {
    if (!isJudged() || next_ == 0 || look.kind == Look::Kind::kNothingSeen) return kNone;
    const Vector5 state = moved(batch_.path.state(next_ - 1), corrected(since_kept_));
    return ::bearing_calibration::residualOf(look.sight, state, batch_.errors.mean);
  }

  const std::vector<Sight>& sights_;
  const BatchEstimate& batch_;
  std::vector<bool> left_out_;  ///< of each sight
  std::size_t next_ = 0;        ///< sight that has not been passed yet
  bool is_first_ = true;
  double distance_m_ = 0.0;
  Pose2 first_from_kept_;         ///< at the last sight that was passed
  OdometryIncrement since_kept_;  ///< motion since then
};

}  // namespace

const char* nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNothingSeen:
      return "nothing seen";
    case Verdict::kUsed:
      return "used";
    case Verdict::kLeftOut:
      return "left out";
    case Verdict::kThinned:
      return "thinned";
    case Verdict::kUnjudged:
      return "unjudged";
  }
  return "";
}

RecordReview::RecordReview(const InitializerConfig& config)
    : config_(config), record_(wideRecord(config.record)) {}

void RecordReview::add(const Look& look) {
  if (look.lost_light) {
    looks_.clear();
    record_.clear();
    motion_since_sight_ = {};
  }
  looks_.push_back(look);
  motion_since_sight_ = append(motion_since_sight_, look.sight.motion);
  if (look.kind == Look::Kind::kNothingSeen) return;
  Sight sight = look.sight;
  sight.motion = motion_since_sight_;
  record_.add(sight);
  motion_since_sight_ = {};
}

Review RecordReview::conclude(const std::optional<RobotEstimate>& running) const {
  Review review;
  const std::vector<Sight>& sights = record_.sights();
  review.motion = summariseMotion(sights);
  review.estimate = running;
  if (!running && !sights.empty()) {
    review.start = findStart(sights, config_);
    if (review.start.ready()) review.estimate = {review.start.estimate, review.start.errors};
  }
  BatchEstimate batch;
  if (review.estimate && !sights.empty()) {
    // the running estimate is at the last image, which may have shown nothing
    const Vector5 at_last_sight =
        running ? moved(running->cartesian.mean, motion_since_sight_.start_from_end.inverse())
                : review.estimate->cartesian.mean;
    const BatchEstimator estimator(config_.batch);
    batch = estimator.estimate(sights,
                               {at_last_sight, sights.size() - 1, review.estimate->errors.mean});
    if (config_.noise.any()) {
      review.noise = findNoiseLevels(sights, batch, config_.batch.errors, config_.noise);
      batch = estimator.estimate(withNoise(sights, review.noise), surestStart(batch));
    }
    review.correlation_time = correlationTime(sights, batch.correlation);
    review.settled = batch.converged && batch.inlierFraction() >= config_.min_inlier_fraction;
    review.slips = static_cast<int>(batch.slips.size());
    review.correlation = batch.correlation;
    if (review.settled) review.estimate = batch.robot();
  }
  if (!review.settled) batch = {};
  Walk walk(sights, batch);
  review.looks.reserve(looks_.size());
  for (const Look& look : looks_) review.looks.push_back(walk.review(look));
  return review;
}

}  // namespace bearing_calibration
