#include "bearing_calibration/calibration/landmark.h"

namespace bearing_calibration::core {

AssociationOutcome Landmark::process(const BearingSet& image, const OdometryIncrement& motion,
                                     const OdometryWindow& nearby) {
  const AssociationOutcome outcome = calibration_.process(image, motion, nearby);
  if (outcome.kind == AssociationOutcome::Kind::kTaken) last_seen_ = image.stamp;
  if (outcome.lost_light) {
    forget();
    mount_moved_m_.reset();
  }
  return outcome;
}

void Landmark::forget() {
  is_sound_ = false;
  one_mount_since_m_.reset();
}

void Landmark::review(double way_m) {
  if (saysMountMoved() && !mount_moved_m_) mount_moved_m_ = way_m;
  const std::optional<LandmarkSolution>& answer = calibration_.solution();
  if (!answer || !isFound() || calibration_.judgement()->state == CalibrationState::kInconsistent) {
    forget();
    return;
  }
  if (answer->stamps.back() == answered_) return;
  answered_ = answer->stamps.back();
  if (!answer->tells_one_mount) {
    forget();
    return;
  }
  if (!one_mount_since_m_) one_mount_since_m_ = answer->motion_m;
  is_sound_ = answer->motion_m - *one_mount_since_m_ >= kHeldOver_m;
}

std::string Landmark::obstacle() const {
  if (!isFound()) return "not found yet";
  const Judgement& judgement = *calibration_.judgement();
  if (judgement.state == CalibrationState::kInconsistent) return judgement.advice;
  return is_sound_ ? "" : "not yet confirmed";
}

std::string nameOf(const Landmark& light, std::size_t place) {
  const std::int32_t id = light.lightId();
  return id == kUnknownLight ? "light number " + std::to_string(place + 1)
                             : "light " + std::to_string(id);
}

}  // namespace bearing_calibration::core
