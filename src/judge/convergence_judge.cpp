#include "bearing_calibration/judge/convergence_judge.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/judge/fault_finder.h"
#include "bearing_calibration/solve/metric_scale.h"

namespace bearing_calibration::core {
namespace {

constexpr int kFewestImages = 30;  // below it, innovations say little
/// Mean of up to 100 NIS, each chi-square of one degree: 1 with a deviation of 0.14 when all is
/// well; 2 leaves room for bearing noise that is correlated from image to image.
constexpr double kLargestNisMean = 2.0;
/// Of the mean of a few, which scatters more: one in a million looks.
constexpr double kNisFalseAlarm = 1e-6;
constexpr double kSmallestFusedShare = 0.5;
/// False alarms of the test for a jump of the mount in a run without end: half of what all tests
/// together may have, a thousandth.
constexpr double kDisplacementFalseAlarm = 5e-4;
/// Jumps are tested anywhere, again and again as the record grows: so many of them, at most, are
/// independent in ten metres of way.
constexpr double kIndependentDisplacements = 100.0;
constexpr double kBlock_m = 10.0;
/// A displacement looks like a slip at first, and is given up as one. So a jump there is more
/// likely, and there are few of them: about so many independent looks at one, as the record grows.
constexpr double kIndependentDisplacementsAtSlip = 10.0;

/// Gain that a jump may have by chance in a record of this way. The false alarms are shared out
/// over blocks of way, 1/2 for the first, 1/6, 1/12 and so on, which is 1 in all.
double largestGainByChance(double way_m) {
  const double block = 1.0 + std::floor(way_m / kBlock_m);
  const double share = 1.0 / (block * (block + 1.0));
  return chiSquareExceededBy(kDisplacementFalseAlarm * share / kIndependentDisplacements,
                             kMountSize);
}

double largestGainAtSlip() {
  return chiSquareExceededBy(kDisplacementFalseAlarm / kIndependentDisplacementsAtSlip, kMountSize);
}

const DisplacementTest& larger(const DisplacementTest& a, const DisplacementTest& b) {
  return a.gain < b.gain ? b : a;
}

double wayOf(const std::vector<Observation>& record, const BatchEstimate& fit) {
  double way_m = fit.beginning ? fit.beginning->distance_m : 0.0;
  for (const Observation& observation : record) way_m += observation.motion.distance_m;
  return way_m;
}

/// The jump of the mount that the record tells, if any, with so many times the noise's variance.
std::optional<DisplacementTest> findDisplacement(const BatchEstimate& fit, double way_m,
                                                 double more_variance = 1.0) {
  DisplacementTest most;
  for (const MountDisplacement& jump : fit.mount_displacements)
    most = larger(most, testDisplacement(jump));
  if (most.gain > more_variance * largestGainByChance(way_m)) return most;
  most = {};
  for (std::size_t slip : fit.slips)
    most = larger(most, testDisplacement(fit.mount_displacements[slip]));
  if (most.gain > more_variance * largestGainAtSlip()) return most;
  return std::nullopt;
}

double motionTo(const Observation& observation) {
  return motionOf(observation.motion.distance_m, observation.motion.rotation_rad);
}

/// Index of the first observation after half of the record's motion.
std::size_t middleByMotion(const std::vector<Observation>& record) {
  double rest_m = 0.5 * motionOf(record, std::nullopt);
  std::size_t middle = 0;
  while (middle + 1 < record.size() && rest_m > 0.0) rest_m -= motionTo(record[middle++]);
  return middle;
}

/// Whether both halves of the record tell all of the mount.
bool bothHalvesTell(const std::vector<Observation>& record, const BatchEstimate& settled) {
  return testDisplacement(settled.mount_displacements[middleByMotion(record)]).directions >=
         kMountSize;
}

/// Mean of so many NIS that a consistent filter does not exceed.
double largestNisMean(int count) {
  return std::max(kLargestNisMean, chiSquareQuantile(1.0 - kNisFalseAlarm, count) / count);
}

}  // namespace

void ConvergenceConfig::declare(Parameters& params) {
  using namespace plausible;
  params.number("converged/position_stddev", position_stddev_m, kLeastLength_m, kFarthest_m);
  params.number("converged/yaw_stddev", yaw_stddev_rad, kLeastAngle_rad, kTurn_rad);
}

double motionOf(double distance_m, double rotation_rad) {
  constexpr double kLever_m = 0.5;
  return distance_m + kLever_m * rotation_rad;
}

bool meetsTargets(const MountEstimate& mount, const ConvergenceConfig& config) {
  const Eigen::Vector3d stddev = mount.covariance.diagonal().cwiseSqrt();
  return stddev.x() <= config.position_stddev_m && stddev.y() <= config.position_stddev_m &&
         stddev.z() <= config.yaw_stddev_rad;
}

Judgement notYetConverged(const StateEstimate& estimate, const ErrorPriors& errors,
                          const std::string& by, const std::string& cure) {
  constexpr double kWorthAWord = 6.0;  // of doubt: one sound robot in eighty
  const Diagnosis wheels = unlikelyWheels(estimate.errors(), errors);
  if (wheels.fault != Fault::kNone) {
    return {CalibrationState::kInconsistent, describe(wheels), wheels.fault};
  }
  const bool is_doubtful = doubtOfLengths(estimate.errors(), errors) > kWorthAWord;
  const Eigen::Vector3d stddev = estimate.mount().covariance.diagonal().cwiseSqrt();
  return {CalibrationState::kConverging,
          formatted("position known to %.3f m and yaw to %.2f deg%s: ", stddev.head<2>().maxCoeff(),
                    degreesFromRadians(stddev.z()), by.c_str()) +
              (is_doubtful ? "the drive contradicts the wheels' radii or separation: measure them "
                             "again"
                           : cure)};
}

bool tellsOneMount(const MountTracker& tracker, const std::vector<Observation>& record,
                   const BatchEstimate& settled) {
  return !tracker.isSearching() && !findDisplacement(settled, wayOf(record, settled)) &&
         bothHalvesTell(record, settled);
}

std::optional<std::string> doubtAbout(const Consistency& recent, double more_variance) {
  const int images = recent.fused + recent.not_fused;
  if (images < kFewestImages) return std::nullopt;
  if (recent.fused < kSmallestFusedShare * images) {
    return formatted(
        "%d of the last %d bearings do not fit the motion: is the light hidden, did it "
        "move, does a wheel slip, are the wheels' parameters right?",
        recent.not_fused, images);
  }
  if (recent.fused > 0 && recent.nis_mean > more_variance * largestNisMean(recent.fused)) {
    return formatted(
        "the bearings scatter %.1f times as much as they should: check the latency, the "
        "wheels' parameters, or raise bearings/extra_stddev",
        std::sqrt(recent.nis_mean));
  }
  return std::nullopt;
}

void Judgement::doubt(const Consistency& recent) {
  if (state != CalibrationState::kConverged) return;
  if (const auto doubt = doubtAbout(recent)) *this = {CalibrationState::kConverging, *doubt};
}

ConvergenceJudge::ConvergenceJudge(const ConvergenceConfig& config, const ErrorPriors& errors)
    : config_(config), errors_(errors) {}

void ConvergenceJudge::judge(const MountTracker& tracker, const std::vector<Observation>& record,
                             const std::optional<SlipAverage>& settled, const NoiseMargin& margin) {
  last_ = decide(tracker, record, settled, margin);
  if (last_.state != CalibrationState::kConverged) {
    if (!confirmed_) good_since_m_.reset();
    return;
  }
  const double motion_m = motionOf(record, settled->best.beginning);
  if (!good_since_m_) good_since_m_ = motion_m;
  confirmed_ = confirmed_ || motion_m - *good_since_m_ >= kHeldOver_m;
  if (!confirmed_) {
    last_ = {CalibrationState::kConverging,
             "accurate enough: the next metre and turn must confirm it"};
  } else {
    last_ = claimed_.claim(tracker.filter().estimate().mount(), motion_m);
  }
}

Judgement ClaimedMount::claim(const MountEstimate& mount, double motion_m) {
  if (staysWhereItWas(mount, motion_m)) {
    return {CalibrationState::kConverged, adviceFor(CalibrationState::kConverged)};
  }
  return {CalibrationState::kConverging,
          "the estimate has changed by more than its uncertainty: the next metre and turn must "
          "confirm it"};
}

bool ClaimedMount::staysWhereItWas(const MountEstimate& mount, double motion_m) {
  constexpr double kFalseAlarm = 1e-4;
  static const double kLargest = chiSquareQuantile(1.0 - kFalseAlarm, kMountSize);
  const auto isAt = [&mount](const MountEstimate& place) {
    return chiSquareOf(mountDifference(mount.mean, place.mean), place.covariance) <= kLargest;
  };
  if (claimed_ && !isAt(*claimed_)) {
    if (!leap_ || !isAt(leap_->to)) leap_ = Leap{mount, motion_m};
    if (motion_m - leap_->since_m < kHeldOver_m) return false;
  }
  leap_.reset();
  claimed_ = mount;
  return true;
}

Judgement ConvergenceJudge::decide(const MountTracker& tracker,
                                   const std::vector<Observation>& record,
                                   const std::optional<SlipAverage>& settled,
                                   const NoiseMargin& margin) {
  if (mount_moved_) return *mount_moved_;
  const auto doubt = doubtAbout(tracker.consistency());
  if (doubt && doubtAbout(tracker.consistency(), margin.scatter)) {
    return {CalibrationState::kInconsistent, *doubt, Fault::kScatter};
  }
  const StateEstimate estimate =
      withNearness(tracker.filter().estimate(), errors_.nearness_stddev_m);
  if (!settled) return stillConverging(estimate);
  // What comes after the light was lost may be another light for a while, or the light after a
  // displacement.
  const bool sure_of_light = !tracker.isSearching();
  const double way_m = wayOf(record, settled->best);
  const std::optional<DisplacementTest> jump =
      sure_of_light ? findDisplacement(settled->best, way_m) : std::nullopt;
  const bool beats_noise = jump && findDisplacement(settled->best, way_m, margin.jump);
  if (beats_noise && confirmed_) {
    mount_moved_ = mountMoved(*jump);
    return *mount_moved_;
  }
  if (!meetsTargets(estimate.mount(), config_)) return stillConverging(estimate);
  if (doubt) {
    return {
        CalibrationState::kConverging,
        "accurate enough, but the bearings scatter more than the noise that was estimated: drive "
        "on until it is estimated anew"};
  }
  if (jump && !beats_noise) {
    return {CalibrationState::kConverging,
            "accurate enough, but two parts of the drive give different mounts, unless the noise "
            "is larger than estimated: drive straight and turn once more"};
  }
  if (jump) {
    return {CalibrationState::kInconsistent,
            "two parts of the drive give different mounts: check the latency and the wheels' "
            "parameters, and whether mount and light are fixed",
            Fault::kPartsDisagree};
  }
  if (!sure_of_light && !confirmed_) {
    return {CalibrationState::kConverging,
            "accurate enough, but the light was lost: drive on until it is seen again"};
  }
  if (settled->rival.isOpen()) {
    return {CalibrationState::kConverging,
            "accurate enough, but another mount explains the bearings nearly as well, for instance "
            "one with a wheel slip: drive straight and turn once more"};
  }
  if (!bothHalvesTell(record, settled->best)) {
    return {CalibrationState::kConverging,
            "accurate enough, but not yet confirmed: drive straight and turn once more"};
  }
  return {CalibrationState::kConverged, adviceFor(CalibrationState::kConverged)};
}

Judgement ConvergenceJudge::mountMoved(const DisplacementTest& jump) {
  return {CalibrationState::kInconsistent,
          formatted("the mount seems to have moved by %.3f m and %.1f deg since it was calibrated: "
                    "call ~reset to calibrate anew",
                    jump.jump.head<2>().norm(), degreesFromRadians(jump.jump.z())),
          Fault::kMountMoved};
}

Judgement ConvergenceJudge::stillConverging(const StateEstimate& estimate) const {
  return notYetConverged(
      estimate, errors_, "",
      formatted("keep driving straight lines and turns; the light is %.1f m away, nearer is better",
                estimate.cartesian().range()));
}

}  // namespace bearing_calibration::core
