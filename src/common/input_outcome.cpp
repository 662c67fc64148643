#include "bearing_calibration/common/input_outcome.h"

#include <numeric>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

std::uint32_t sumFrom(InputStatus first, const InputCounts& counts) {
  return std::accumulate(counts.by_status.begin() + static_cast<std::ptrdiff_t>(first),
                         counts.by_status.end(), 0U);
}

}  // namespace

const char* nameOf(InputStatus status) {
  switch (status) {
    case InputStatus::kAccepted:
      return "accepted";
    case InputStatus::kIgnoredPaused:
      return "ignored while paused";
    case InputStatus::kVarianceRaised:
      return "variance raised to that of bearings/min_stddev";
    case InputStatus::kGeometryChanged:
      return "sensor's geometry known less well than before";
    case InputStatus::kNoStamp:
      return "stamp is zero";
    case InputStatus::kStampInFuture:
      return "stamp in the future";
    case InputStatus::kStampNotAfterLast:
      return "stamp not after the last";
    case InputStatus::kAzimuthNotFinite:
      return "azimuth not finite";
    case InputStatus::kAzimuthBeyondATurn:
      return "azimuth beyond 2 pi (in degrees?)";
    case InputStatus::kVarianceNotPositive:
      return "variance not positive";
    case InputStatus::kVarianceAbsurd:
      return "variance too large";
    case InputStatus::kProbabilityOutOfRange:
      return "probability not in 0 to 1";
    case InputStatus::kGeometryAbsurd:
      return "sensor's geometry impossible";
    case InputStatus::kGeometryUnmodelled:
      return "sensor's geometry not in the paper's filter";
    case InputStatus::kCounterReset:
      return "counter reset";
    case InputStatus::kTicksTooFast:
      return "wheel faster than possible";
    case InputStatus::kTicksGap:
      return "gap hides a counter wrap";
    case InputStatus::kTicksOutOfRange:
      return "count exceeds the counter";
    case InputStatus::kAngleNotFinite:
      return "joint position not finite";
    case InputStatus::kNoPartner:
      return "no reading of the other wheel";
    case InputStatus::kQueueFull:
      return "too many bearings wait for ticks";
    case InputStatus::kTicksLost:
      return "no ticks for the bearing's stamp";
  }
  return "unknown";
}

std::string describe(const InputOutcome& outcome) {
  const std::string value = formatted("%.9g", outcome.value);
  switch (outcome.status) {
    case InputStatus::kAccepted:
      return "accepted";
    case InputStatus::kIgnoredPaused:
      return "the calibration is paused: ignored";
    case InputStatus::kVarianceRaised:
      return "a stated variance of " + value +
             " rad^2 is below that of bearings/min_stddev: raised to it; state the spread that is "
             "seen while the robot stands";
    case InputStatus::kGeometryChanged:
      return "the sensor now states a harmonic's standard deviation of " + value +
             " rad, more than before: the calibration begins again";
    case InputStatus::kNoStamp:
      return "the stamp is zero: left out";
    case InputStatus::kStampInFuture:
      return "the stamp lies " + value + " s after the time of receipt: left out";
    case InputStatus::kStampNotAfterLast:
      return "the stamp lies " + value + " s before the last one, or repeats it: left out";
    case InputStatus::kAzimuthNotFinite:
      return "azimuth " + value + " rad is not finite: candidate left out";
    case InputStatus::kAzimuthBeyondATurn:
      return "azimuth " + value +
             " lies beyond 2 pi: is it in degrees? bearings are in radians: candidate left out";
    case InputStatus::kVarianceNotPositive:
      return "azimuth variance " + value + " rad^2 is not positive: candidate left out";
    case InputStatus::kVarianceAbsurd:
      return "azimuth variance " + value +
             " rad^2 is above the largest allowed: candidate left out";
    case InputStatus::kProbabilityOutOfRange:
      return "probability " + value + " is not in 0 to 1: candidate left out";
    case InputStatus::kGeometryAbsurd:
      return "the sensor states " + value +
             " of its geometry (harmonic_stddev, near_per_far, nearness_stddev), which no mirror "
             "has: message left out";
    case InputStatus::kGeometryUnmodelled:
      return "the sensor states a harmonic's standard deviation of " + value +
             " rad (alignment/harmonic_stddev), for which the paper's filter has no state: message "
             "left out";
    case InputStatus::kCounterReset:
      return "the counters jumped by " + value +
             " m to near zero: taken as a reset by the driver, followed from there";
    case InputStatus::kTicksTooFast:
      return "a wheel would have rolled " + value +
             " m, faster than wheels/max_speed allows: reading left out";
    case InputStatus::kTicksGap:
      return "no readings for " + value +
             " s, long enough for a counter or a joint to wrap unseen: the motion meanwhile is "
             "unknown";
    case InputStatus::kTicksOutOfRange:
      return "the count " + value + " does not fit wheels/counter_bits: reading left out";
    case InputStatus::kAngleNotFinite:
      return "the joint position " + value + " rad is not finite: reading left out";
    case InputStatus::kNoPartner:
      return "the other wheel has no reading for " + value + " s around it: reading left out";
    case InputStatus::kQueueFull:
      return "more than " + value + " bearings wait for ticks: the oldest one dropped";
    case InputStatus::kTicksLost:
      return "the bearing lies " + value + " s before the oldest remembered ticks: dropped";
  }
  return "unknown outcome";
}

std::uint32_t InputCounts::badInputs() const { return sumFrom(InputStatus::kNoStamp, *this); }

std::uint32_t InputCounts::remarks() const { return sumFrom(InputStatus::kVarianceRaised, *this); }

}  // namespace bearing_calibration::core
