#include "bearing_calibration/calibration/start_search.h"

#include <chrono>

#include "bearing_calibration/judge/driver_advice.h"

namespace bearing_calibration::core {
namespace {

constexpr Pace kAttempts{std::chrono::seconds(1), 0.05};  // tens of milliseconds
/// On a record that nothing explains, which takes longest.
constexpr Pace kAttemptsInVain{std::chrono::seconds(2), 0.1};

/// A light that is passed closely, or a slip, can make one attempt fail; not so many in a row.
constexpr int kMisfitsToSay = 5;

}  // namespace

StartSearch::StartSearch(const CalibratorConfig& config) : weak_filter_(config.filter) {
  weak_filter_.parametrisation =
      FilterConfig::Parametrisation::kCartesian;  // in which a motion is linear
}

void StartSearch::move(const OdometryIncrement& motion) {
  if (weak_) weak_->move(motion);
}

const StartAttempt& StartSearch::attempt(const Initializer& initializer) {
  std::optional<NoiseLevels> noise_before;
  if (attempt_ && attempt_->obstacle >= StartObstacle::kLightTooNear)
    noise_before = attempt_->noise;
  attempt_ = initializer.attempt(noise_before);
  is_refuted_ = false;
  weak_.reset();
  if (attempt_->obstacle == StartObstacle::kWeakDirection) {
    weak_.emplace(weak_filter_, attempt_->estimate, attempt_->bearing_correlation);
  }
  misfits_ = doesNotFit(*attempt_) ? misfits_ + 1 : 0;
  attempts_.begin(initializer.record(), isInVain() ? kAttemptsInVain : kAttempts);
  return *attempt_;
}

bool StartSearch::isInVain() const { return is_refuted_ || misfits_ >= kMisfitsToSay; }

void StartSearch::describe(CalibrationResult* result) const {
  if (!attempt_) return;
  result->state = isInVain()                ? CalibrationState::kInconsistent
                  : isDegenerate(*attempt_) ? CalibrationState::kDegenerateMotion
                                            : CalibrationState::kInitialising;
  result->advice = adviceFor(*attempt_);
  if (isInVain()) result->cause = Fault::kUnexplained;
}

}  // namespace bearing_calibration::core
