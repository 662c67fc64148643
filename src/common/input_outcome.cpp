#include "bearing_calibration/common/input_outcome.h"

#include <iterator>
#include <numeric>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

struct StatusWords {
  InputStatus status;
  const char* name;
  const char* sentence;  ///< a printf format of the value
};

constexpr StatusWords kStatusWords[] = {
    {InputStatus::kAccepted, "accepted", "accepted"},
    {InputStatus::kIgnoredPaused, "ignored while paused", "the calibration is paused: ignored"},
    {InputStatus::kVarianceRaised, "variance raised to that of bearings/min_stddev",
     "a stated variance of %.9g rad^2 is below that of bearings/min_stddev: raised to it; state "
     "the spread that is seen while the robot stands"},
    {InputStatus::kElevationLeftOut, "elevation beyond pi/2 (in degrees?)",
     "elevation %.9g lies beyond pi/2: is it in degrees? bearings are in radians: candidate used "
     "without it"},
    {InputStatus::kGeometryChanged, "sensor's geometry changed",
     "the sensor now states another geometry, with a harmonic's standard deviation of %.9g rad, or "
     "less that is known of it: the calibration begins again"},
    {InputStatus::kNoStamp, "stamp is zero", "the stamp is zero: left out"},
    {InputStatus::kStampInFuture, "stamp in the future",
     "the stamp lies %.9g s after the time of receipt: left out"},
    {InputStatus::kStampNotAfterLast, "stamp not after the last",
     "the stamp lies %.9g s before the last one, or repeats it: left out"},
    {InputStatus::kAzimuthNotFinite, "azimuth not finite",
     "azimuth %.9g rad is not finite: candidate left out"},
    {InputStatus::kAzimuthBeyondATurn, "azimuth beyond 2 pi (in degrees?)",
     "azimuth %.9g lies beyond 2 pi: is it in degrees? bearings are in radians: candidate left "
     "out"},
    {InputStatus::kVarianceNotPositive, "variance not positive",
     "azimuth variance %.9g rad^2 is not positive: candidate left out"},
    {InputStatus::kVarianceAbsurd, "variance too large",
     "azimuth variance %.9g rad^2 is above the largest allowed: candidate left out"},
    {InputStatus::kProbabilityOutOfRange, "probability not in 0 to 1",
     "probability %.9g is not in 0 to 1: candidate left out"},
    {InputStatus::kProbabilityZero, "probability is zero",
     "the probability is %.9g, as where nobody fills it in: candidate left out; a sensor that does "
     "not know it states 1"},
    {InputStatus::kGeometryAbsurd, "sensor's geometry impossible",
     "the sensor states %.9g of its geometry (harmonic_stddev, near_per_far, nearness_stddev), "
     "which no mirror has: message left out"},
    {InputStatus::kGeometryUnmodelled, "sensor's geometry not in the paper's filter",
     "the sensor states a harmonic's standard deviation of %.9g rad "
     "(alignment/harmonic_stddev), for which the paper's filter has no state: message left "
     "out"},
    {InputStatus::kViewImpossible, "sensor's field of view impossible",
     "the sensor states a field of view (view_centre, view_width) of %.9g rad, which is no part of "
     "a turn: message left out"},
    {InputStatus::kCounterReset, "counter reset",
     "the counters or the odometry's pose jumped by %.9g m: taken as a reset by the driver, "
     "followed from there"},
    {InputStatus::kTicksTooFast, "wheel faster than possible",
     "a wheel would have rolled %.9g m, faster than wheels/max_speed allows: reading left out"},
    {InputStatus::kTicksGap, "gap hides a counter wrap",
     "no readings for %.9g s, long enough for a counter, a joint or a heading to wrap unseen: the "
     "motion meanwhile is unknown"},
    {InputStatus::kTicksOutOfRange, "count exceeds the counter",
     "the count %.9g does not fit wheels/counter_bits: reading left out"},
    {InputStatus::kAngleNotFinite, "joint position not finite",
     "the joint position %.9g rad is not finite: reading left out"},
    {InputStatus::kPoseNotFinite, "odometry's pose not finite",
     "the odometry's pose has a number %.9g that is not finite: reading left out"},
    {InputStatus::kQuaternionNotUnit, "odometry's quaternion not of length 1",
     "the quaternion of the odometry's orientation has the length %.9g instead of 1: reading left "
     "out"},
    {InputStatus::kFramesChanged, "odometry's frames changed",
     "header.frame_id or child_frame_id of the odometry is not that of the first message (two "
     "publishers?): reading left out"},
    {InputStatus::kTwistWithoutPose, "odometry's pose stands while its twist moves",
     "the odometry's pose stands still while its twist has moved a wheel by %.9g m: only poses are "
     "used, does the driver fill them in? reading left out"},
    {InputStatus::kMovedSideways, "odometry moves sideways",
     "the odometry's pose moved %.9g m sideways, as no two wheels do (a holonomic robot, a base "
     "frame off the wheels' axle, or a pose that localisation corrects?): reading left out"},
    {InputStatus::kNoPartner, "no reading of the other wheel",
     "the other wheel has no reading for %.9g s around it: reading left out"},
    {InputStatus::kQueueFull, "too many bearings wait for ticks",
     "more than %.9g bearings wait for ticks: the oldest one dropped"},
    {InputStatus::kTicksLost, "no ticks for the bearing's stamp",
     "the bearing lies %.9g s before the oldest remembered ticks: dropped"},
};

constexpr bool areInOrder() {
  for (std::size_t i = 0; i < std::size(kStatusWords); ++i) {
    if (kStatusWords[i].status != static_cast<InputStatus>(i)) return false;
  }
  return std::size(kStatusWords) == kInputStatusCount;
}
static_assert(areInOrder(), "one row for each status, in the order of the enumeration");

const StatusWords& wordsOf(InputStatus status) {
  return kStatusWords[static_cast<std::size_t>(status)];
}

std::uint32_t sumFrom(InputStatus first, const InputCounts& counts) {
  return std::accumulate(counts.by_status.begin() + static_cast<std::ptrdiff_t>(first),
                         counts.by_status.end(), 0U);
}

}  // namespace

const char* nameOf(InputStatus status) { return wordsOf(status).name; }

std::string describe(const InputOutcome& outcome) {
  return formatted(wordsOf(outcome.status).sentence, outcome.value);
}

std::uint32_t InputCounts::badInputs() const { return sumFrom(InputStatus::kNoStamp, *this); }

std::uint32_t InputCounts::remarks() const { return sumFrom(InputStatus::kVarianceRaised, *this); }

}  // namespace bearing_calibration::core
