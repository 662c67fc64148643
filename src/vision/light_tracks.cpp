#include "bearing_calibration/vision/light_tracks.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr std::size_t kMostFollowed = 200;  // twice the candidates of one image
// How far a followed candidate is from where it is expected, beside what it may have moved.
constexpr double kOffTrack_rad = 0.05;
constexpr double kOffTrack_px = 6.0;
constexpr double kLongestGap_s = 1.0;  // by then nobody knows which one it was

// Evidence is in logarithms of odds; no single image is surer than this.
constexpr double kMostCertain = 6.0;
// Of an image in which the candidate is not found, or is refused: lights are found in most.
constexpr double kNotFound = -4.0;
// Correlation of two images' evidence of one object, and the mean that is as often that of a light
// as of clutter, which looks a little like a light in every image (detection.md).
constexpr double kRepeated = 0.5;
constexpr double kEven = 1.0;
constexpr int kRemembered = 30;  // [images]

// What stays where it is while the robot turns is on the robot.
constexpr double kTurned_rad = 0.5;
constexpr double kStays_rad = 0.02;
constexpr double kStays_px = 2.0;
constexpr double kOnTheRobot = 10.0;  // taken from the logarithm of the odds

/// As if all of the mask had been searched.
double logOddsOf(double probability, double part_searched) {
  const double log_odds = std::log(part_searched * probability / (1.0 - probability));
  return std::clamp(log_odds, -kMostCertain, kMostCertain);
}

}  // namespace

void LightTracks::follow(double part_searched, const std::optional<BearingPrediction>& expected,
                         BearingSet* set) {
  if (set->stamp < last_stamp_) tracks_.clear();
  last_stamp_ = set->stamp;
  const auto is_gone = [&](const Track& track) {
    return secondsFromDuration(set->stamp - track.seen) > kLongestGap_s;
  };
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), is_gone), tracks_.end());
  for (Track& track : tracks_) track.is_matched = false;
  for (Bearing& candidate : set->candidates) {
    const Sighting sighting{candidate.azimuth_rad, candidate.image_radius_px, expected};
    Track* track = trackOf(candidate, set->stamp);
    if (track == nullptr) {
      if (tracks_.size() == kMostFollowed) continue;
      track = &tracks_.emplace_back(Track{sighting, sighting, set->stamp, 0.0, 0.0, 0, false});
    }
    track->take(sighting, logOddsOf(candidate.probability, part_searched), set->stamp);
    candidate.track_probability = track->probability();
  }
  if (part_searched < 1.0) return;
  for (Track& track : tracks_) {
    if (!track.is_matched) track.weigh(kNotFound);
  }
}

/// The nearest track that the candidate can continue; null without any.
LightTracks::Track* LightTracks::trackOf(const Bearing& candidate, Stamp stamp) {
  Track* nearest = nullptr;
  double least = 1.0;  // parts of the reach
  for (Track& track : tracks_) {
    if (track.is_matched) continue;
    const double gap_s = secondsFromDuration(stamp - track.seen);
    const double expected_rad = track.last.azimuth_rad + track.turn_radps * gap_s;
    const double off_rad = wrapAngle(candidate.azimuth_rad - expected_rad);
    const double off_px = candidate.image_radius_px - track.last.radius_px;
    double off = std::abs(off_rad) / (kOffTrack_rad + config_.max_turn_rate_radps * gap_s);
    // Without a mirror there is no image radius.
    if (!std::isnan(off_px)) {
      off = std::max(off, std::abs(off_px) / (kOffTrack_px + config_.max_radius_rate_pxps * gap_s));
    }
    if (off >= least) continue;
    least = off;
    nearest = &track;
  }
  return nearest;
}

void LightTracks::Track::take(const Sighting& sighting, double log_odds, Stamp stamp) {
  const double gap_s = secondsFromDuration(stamp - seen);
  if (gap_s > 0.0) turn_radps = wrapAngle(sighting.azimuth_rad - last.azimuth_rad) / gap_s;
  const bool is_comparable = first.expected && sighting.expected &&
                             first.expected->light_id == sighting.expected->light_id;
  if (!is_comparable) first = sighting;
  last = sighting;
  seen = stamp;
  is_matched = true;
  weigh(log_odds);
}

void LightTracks::Track::weigh(double log_odds) {
  images = std::min(images + 1, kRemembered);
  mean_log_odds += (log_odds - mean_log_odds) / images;
}

/// Whether it stands still while the light that is expected moves.
bool LightTracks::Track::isOnTheRobot() const {
  if (!first.expected || !last.expected) return false;
  const double turned_rad = wrapAngle(last.expected->azimuth_rad - first.expected->azimuth_rad);
  return std::abs(turned_rad) > kTurned_rad &&
         std::abs(wrapAngle(last.azimuth_rad - first.azimuth_rad)) < kStays_rad &&
         !(std::abs(last.radius_px - first.radius_px) > kStays_px);
}

double LightTracks::Track::probability() const {
  // The mean of n equally correlated numbers says as much as so many independent ones.
  const double independent = images / (1.0 + (images - 1) * kRepeated);
  const double log_odds =
      kEven + independent * (mean_log_odds - kEven) - (isOnTheRobot() ? kOnTheRobot : 0.0);
  return 1.0 / (1.0 + std::exp(-log_odds));
}

}  // namespace bearing_calibration::core
