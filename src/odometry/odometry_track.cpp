#include "bearing_calibration/odometry/odometry_track.h"

#include <algorithm>
#include <stdexcept>

namespace bearing_calibration::core {

OdometryTrack::OdometryTrack(double wheel_separation_m, const WheelNoise& noise, Duration history)
    : wheel_separation_m_(wheel_separation_m), noise_(noise), history_(history) {}

void OdometryTrack::add(const WheelTravel& travel) {
  if (!empty() && travel.stamp <= newest()) {
    throw std::invalid_argument("OdometryTrack::add: the stamp must be later than the last");
  }
  const bool newest_is_late = isNewestLate(travel.stamp);
  if (!empty()) averageInterval(travel.stamp);
  if (newest_is_late) readings_.pop_back();
  left_out_ = newest_is_late ? left_out_ + 1 : 0;
  if (readings_.full()) foldOldest();
  readings_.push_back(travel);
  while (readings_.size() > 2 && readings_[1].stamp < travel.stamp - history_) foldOldest();
}

bool OdometryTrack::isNewestLate(Stamp next) const {
  if (intervals_ < kLeastIntervals || readings_.size() < 2) return false;
  const double half_usual_s = 0.5 * usual_interval_s_;
  const Stamp kept = readings_[readings_.size() - 2].stamp;
  return secondsFromDuration(next - newest()) < half_usual_s &&
         secondsFromDuration(newest() - kept) >= (left_out_ + 1) * half_usual_s;
}

void OdometryTrack::averageInterval(Stamp next) {
  intervals_ = std::min(intervals_ + 1, kMostIntervals);
  usual_interval_s_ += (secondsFromDuration(next - newest()) - usual_interval_s_) / intervals_;
}

bool OdometryTrack::covers(Stamp stamp) const {
  return !empty() && oldest() <= stamp && stamp <= newest();
}

OdometryIncrement OdometryTrack::motionTo(Stamp stamp) const {
  const WheelTravel end = travelAt(stamp);
  if (!anchor_) return {};
  if (stamp < anchor_->stamp) {
    throw std::invalid_argument("OdometryTrack::motionTo: stamp before the anchor");
  }
  OdometryIncrement increment = folded_;
  WheelTravel from = *anchor_;
  auto next = std::upper_bound(
      readings_.begin(), readings_.end(), from.stamp,
      [](Stamp moment, const WheelTravel& reading) { return moment < reading.stamp; });
  for (; next != readings_.end() && next->stamp < stamp; ++next) {
    increment = appendTravel(increment, from, *next);
    from = *next;
  }
  return appendTravel(increment, from, end);
}

OdometryWindow OdometryTrack::travelAround(Stamp stamp) const {
  if (!covers(stamp)) throw std::invalid_argument("OdometryTrack: stamp not covered");
  const Duration step = durationFromSeconds(OdometryWindow::kStep_s);
  std::array<WheelDisplacement, OdometryWindow::kSamples> samples;
  for (int i = 0; i < OdometryWindow::kSamples; ++i) {
    const Stamp moment = stamp + (i - OdometryWindow::kBefore) * step;
    const WheelTravel travel = travelAt(std::clamp(moment, oldest(), newest()));
    auto& sample = samples[static_cast<std::size_t>(i)];
    sample = {travel.left_m, travel.right_m};
    if (moment <= newest() || readings_.size() < 2) continue;
    const WheelTravel before = travelAt(std::max(newest() - step, oldest()));
    const double ahead =
        secondsFromDuration(moment - newest()) / secondsFromDuration(newest() - before.stamp);
    sample.left_m += ahead * (travel.left_m - before.left_m);
    sample.right_m += ahead * (travel.right_m - before.right_m);
  }
  return {samples, wheel_separation_m_};
}

void OdometryTrack::anchorAt(Stamp stamp) {
  anchor_ = travelAt(stamp);
  folded_ = {};
}

WheelTravel OdometryTrack::travelAt(Stamp stamp) const {
  if (!covers(stamp)) throw std::invalid_argument("OdometryTrack: stamp not covered");
  const auto after = std::lower_bound(
      readings_.begin(), readings_.end(), stamp,
      [](const WheelTravel& reading, Stamp moment) { return reading.stamp < moment; });
  if (after->stamp == stamp) return *after;
  const auto before = after - 1;
  const double fraction = secondsFromDuration(stamp - before->stamp) /
                          secondsFromDuration(after->stamp - before->stamp);
  return {stamp, before->left_m + fraction * (after->left_m - before->left_m),
          before->right_m + fraction * (after->right_m - before->right_m),
          before->unseen_variance_m2 +
              fraction * (after->unseen_variance_m2 - before->unseen_variance_m2)};
}

OdometryIncrement OdometryTrack::appendTravel(const OdometryIncrement& increment,
                                              const WheelTravel& from,
                                              const WheelTravel& to) const {
  return append(increment, {to.left_m - from.left_m, to.right_m - from.right_m},
                wheel_separation_m_, noise_, to.unseen_variance_m2 - from.unseen_variance_m2);
}

void OdometryTrack::foldOldest() {
  const WheelTravel& remaining = readings_[1];
  if (anchor_ && anchor_->stamp < remaining.stamp) {
    folded_ = appendTravel(folded_, *anchor_, remaining);
    anchor_ = remaining;
  }
  readings_.pop_front();
}

}  // namespace bearing_calibration::core
