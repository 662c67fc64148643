#include "bearing_calibration/calibration/convergence_judge.h"

#include <cmath>
#include <cstdio>

#include "bearing_calibration/calibration/mount_agreement.h"
#include "bearing_calibration/calibration/slip_suspicion.h"
#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"

namespace bearing_calibration {
namespace {

constexpr int kFewestImages = 30;  // below it, innovations say little
/// Mean of up to 100 NIS, each chi-square of one degree: 1 with a deviation of 0.14 when all is
/// well; 2 leaves room for bearing noise that is correlated from image to image.
constexpr double kLargestNisMean = 2.0;
constexpr double kSmallestFusedShare = 0.5;
/// False alarms of a check; there are some tens of checks in a run.
constexpr double kHalvesFalseAlarm = 1e-4;
constexpr double kWatchFalseAlarm = 1e-4;
constexpr int kDisagreementsToSay = 2;
constexpr double kMountDegrees = 3.0;
/// Stretches of way that are held against all that came before them: a large knock shows after the
/// first, a small one after the last.
constexpr double kWatchedPaths_m[] = {2.5, 5.0, 9.0};

template <class... Numbers>
std::string format(const char* pattern, Numbers... numbers) {
  char text[256];
  std::snprintf(text, sizeof(text), pattern, numbers...);
  return text;
}

/// First sight of the record's last `path_m`; 0 when the record is shorter.
std::size_t beginOfLast(double path_m, const std::vector<Sight>& record) {
  std::size_t begin = record.size();
  for (double covered_m = 0.0; begin > 0 && covered_m < path_m;) {
    covered_m += record[--begin].motion.distance_m;
  }
  return begin;
}

}  // namespace

ConvergenceJudge::ConvergenceJudge(const ConvergenceConfig& config, const BatchConfig& batch)
    : config_(config), batch_(batch) {}

void ConvergenceJudge::judge(const MountTracker& tracker, const std::vector<Sight>& record,
                             const std::optional<BatchEstimate>& settled) {
  last_ = decide(tracker, record, settled);
}

Judgement ConvergenceJudge::decide(const MountTracker& tracker, const std::vector<Sight>& record,
                                   const std::optional<BatchEstimate>& settled) {
  if (const auto why = inconsistency(tracker.consistency())) {
    return {CalibrationState::kInconsistent, *why};
  }
  const CartesianEstimate estimate = tracker.filter().cartesian();
  if (!settled || !meetsTargets(mountFromCartesian(estimate))) return stillConverging(estimate);
  if (hidesSlip(record, *settled, batch_)) {
    return {CalibrationState::kConverging,
            "known well enough unless a wheel has slipped unnoticed: drive on to tell"};
  }
  if (confirmed_) return watch(estimate, record);
  return confirm(estimate, record);
}

std::optional<std::string> ConvergenceJudge::inconsistency(const Consistency& recent) const {
  const int images = recent.fused + recent.not_fused;
  if (images < kFewestImages) return std::nullopt;
  if (recent.fused < kSmallestFusedShare * images) {
    return format(
        "%d of the last %d bearings do not fit the motion: is the light hidden, did it "
        "move, does a wheel slip, are the wheels' parameters right?",
        recent.not_fused, images);
  }
  if (recent.nis_mean > kLargestNisMean) {
    return format(
        "the bearings scatter %.1f times as much as they should: check the latency, the "
        "wheels' parameters, or raise bearings/extra_stddev",
        std::sqrt(recent.nis_mean));
  }
  return std::nullopt;
}

Judgement ConvergenceJudge::confirm(const CartesianEstimate& estimate,
                                    const std::vector<Sight>& record) {
  const std::optional<double> chi_square = halvesDisagreement(record, estimate.mean, batch_);
  if (!chi_square) {
    return {CalibrationState::kConverging,
            "known well enough, but not yet confirmed: drive straight and turn once more"};
  }
  if (*chi_square > chiSquareQuantile(1.0 - kHalvesFalseAlarm, kMountDegrees)) {
    return {CalibrationState::kInconsistent,
            "the two halves of the drive give different mounts: check the latency and the wheels' "
            "parameters, and whether mount and light are fixed"};
  }
  confirmed_ = true;
  return {CalibrationState::kConverged, adviceFor(CalibrationState::kConverged)};
}

Judgement ConvergenceJudge::watch(const CartesianEstimate& estimate,
                                  const std::vector<Sight>& record) {
  const std::optional<Eigen::Vector3d> moved = findMove(estimate, record);
  disagreements_in_a_row_ = moved ? disagreements_in_a_row_ + 1 : 0;
  if (disagreements_in_a_row_ < kDisagreementsToSay) {
    return {CalibrationState::kConverged, adviceFor(CalibrationState::kConverged)};
  }
  return {CalibrationState::kInconsistent,
          format("the mount seems to have moved by %.3f m and %.1f deg since it was calibrated: "
                 "call ~reset to calibrate anew",
                 moved->head<2>().norm(), degreesFromRadians(moved->z())),
          true};
}

std::optional<Eigen::Vector3d> ConvergenceJudge::findMove(const CartesianEstimate& estimate,
                                                          const std::vector<Sight>& record) const {
  const double limit = chiSquareQuantile(1.0 - kWatchFalseAlarm, kMountDegrees);
  for (double path_m : kWatchedPaths_m) {
    const std::size_t begin = beginOfLast(path_m, record);
    const auto before = estimatePart(record, estimate.mean, 0, begin, batch_);
    const auto recent = estimatePart(record, estimate.mean, begin, record.size(), batch_);
    if (!before || !recent || disagreement(*before, *recent) <= limit) continue;
    Eigen::Vector3d moved = recent->mean - before->mean;
    moved.z() = wrapAngle(moved.z());
    return moved;
  }
  return std::nullopt;
}

bool ConvergenceJudge::meetsTargets(const MountEstimate& mount) const {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return stddev.x() <= config_.position_stddev_m && stddev.y() <= config_.position_stddev_m &&
         stddev.z() <= config_.yaw_stddev_rad;
}

Judgement ConvergenceJudge::stillConverging(const CartesianEstimate& estimate) const {
  const Eigen::Vector3d stddev = mountFromCartesian(estimate).covariance.diagonal().cwiseSqrt();
  return {CalibrationState::kConverging,
          format("position known to %.3f m and yaw to %.2f deg: keep driving straight lines and "
                 "turns; the light is %.1f m away, nearer is better",
                 stddev.head<2>().maxCoeff(), degreesFromRadians(stddev.z()),
                 (estimate.lightInBase() - estimate.sensorInBase()).norm())};
}

}  // namespace bearing_calibration
