#include "bearing_calibration/calibration/light_member.h"

namespace bearing_calibration {

Look LightMember::look(const BearingSet& image, const OdometryIncrement& motion,
                       const TravelNearby& nearby) {
  const Look look = calibration_.look(image, motion, nearby);
  if (look.kind == Look::Kind::kTaken) last_seen_ = image.stamp;
  if (look.lost_light) {
    forget();
    knock_heard_m_.reset();
  }
  return look;
}

void LightMember::forget() {
  is_sound_ = false;
  one_mount_since_m_.reset();
}

void LightMember::review(double way_m) {
  if (isKnocked() && !knock_heard_m_) knock_heard_m_ = way_m;
  const std::optional<OwnAnswer>& answer = calibration_.ownAnswer();
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

std::string LightMember::obstacle() const {
  if (!isFound()) return "not found yet";
  const Judgement& judgement = *calibration_.judgement();
  if (judgement.state == CalibrationState::kInconsistent) return judgement.advice;
  return is_sound_ ? "" : "not yet confirmed";
}

}  // namespace bearing_calibration
