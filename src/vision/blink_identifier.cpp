#include "bearing_calibration/vision/blink_identifier.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

// A light's image is some degrees wide: two lights nearer to each other are one anyway.
constexpr double kSamePlace_rad = 0.05;
constexpr std::size_t kMostTracks = 200;  // twice the candidates of one image
// A rate is told from its mirror image about half of the frame rate when there are a few more
// frames than two in a period.
constexpr double kFramesPerPeriod = 2.4;
// Of a steady light the brightness scatters by some percent of its mean; of one that goes on and
// off it scatters by all of it.
constexpr double kLeastModulation = 0.3;
// Part of the window for which a candidate must have been followed.
constexpr double kLeastPartOfWindow = 0.8;

}  // namespace

void BlinkConfig::declare(Parameters& params) {
  constexpr double kLeastPeriods = 3.0;  // fewer, and a passing shadow blinks, too
  constexpr double kLongestWindow_s = 60.0;
  params.read("blink/use", use);
  params.number("blink/rate", rate_hz, plausible::kRarest_hz, plausible::kMostFrequent_hz);
  params.number("blink/window", window_s, 0.0, kLongestWindow_s);
  params.that(window_s * rate_hz >= kLeastPeriods,
              "blink/window must hold at least three periods of blink/rate, but holds " +
                  std::to_string(window_s * rate_hz));
  params.number("blink/min_part_at_rate", min_part_at_rate, 0.0, 1.0);
  params.number("time/max_turn_rate", max_turn_rate_radps, 0.0, plausible::kFastestTurn_radps);
  params.integer("blink/light_id", light_id, 0, std::numeric_limits<int>::max());
}

BlinkIdentifier::BlinkIdentifier(const BlinkConfig& config) : config_(validated(config)) {}

void BlinkIdentifier::identify(const std::vector<Detection>& lights, BearingSet* set) {
  if (lights.size() != set->candidates.size()) {
    throw std::invalid_argument("a light is needed for each candidate");
  }
  if (set->stamp < last_stamp_) tracks_.clear();
  last_stamp_ = set->stamp;
  forgetBefore(set->stamp - durationFromSeconds(config_.window_s));
  for (Track& track : tracks_) track.matched = false;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    Bearing& candidate = set->candidates[i];
    Track* track = trackOf(candidate, set->stamp);
    const bool is_the_light = track != nullptr && blinks(*track);
    if (track != nullptr) {
      track->azimuth_rad = candidate.azimuth_rad;
      track->seen = set->stamp;
      track->matched = true;
      track->samples.push_back({set->stamp, lights[i].ellipse.mass_levels});
    }
    candidate.light_id = is_the_light ? config_.light_id : kUnknownLight;
    if (!is_the_light) candidate.probability = 0.0;
  }
  for (Track& track : tracks_) {
    if (!track.matched) track.samples.push_back({set->stamp, 0.0});
  }
}

/// The nearest track that the candidate can continue, or a new one; null when there are too many.
BlinkIdentifier::Track* BlinkIdentifier::trackOf(const Bearing& candidate, Stamp stamp) {
  Track* nearest = nullptr;
  double nearest_rad = 0.0;
  for (Track& track : tracks_) {
    const double apart_rad = std::abs(wrapAngle(candidate.azimuth_rad - track.azimuth_rad));
    const double reach_rad =
        kSamePlace_rad + config_.max_turn_rate_radps * secondsFromDuration(stamp - track.seen);
    const bool possible = !track.matched && apart_rad <= reach_rad;
    if (!possible || (nearest != nullptr && apart_rad >= nearest_rad)) continue;
    nearest = &track;
    nearest_rad = apart_rad;
  }
  if (nearest != nullptr) return nearest;
  if (tracks_.size() == kMostTracks) return nullptr;
  tracks_.push_back({candidate.azimuth_rad, stamp, {}, false});
  return &tracks_.back();
}

/// The part of the brightness' variance that is at the rate (a periodogram), against the bar.
bool BlinkIdentifier::blinks(const Track& track) const {
  const std::vector<Sample>& samples = track.samples;
  const double n = static_cast<double>(samples.size());
  const bool enough =
      n >= kLeastPartOfWindow * kFramesPerPeriod * config_.rate_hz * config_.window_s &&
      secondsFromDuration(samples.back().stamp - samples.front().stamp) >=
          kLeastPartOfWindow * config_.window_s;
  if (!enough) return false;
  double mean = 0.0;
  for (const Sample& sample : samples) mean += sample.brightness / n;
  double squares = 0.0;
  std::complex<double> wave = 0.0;
  for (const Sample& sample : samples) {
    const double change = sample.brightness - mean;
    const double time_s = secondsFromDuration(sample.stamp - samples.front().stamp);
    squares += change * change;
    wave += std::polar(change, 2.0 * kPi * config_.rate_hz * time_s);
  }
  const bool steady = squares < n * std::pow(kLeastModulation * mean, 2);
  return !steady && 2.0 * std::norm(wave) >= config_.min_part_at_rate * n * squares;
}

/// Samples and tracks of the past.
void BlinkIdentifier::forgetBefore(Stamp stamp) {
  for (Track& track : tracks_) {
    const auto first = std::find_if(track.samples.begin(), track.samples.end(),
                                    [&](const Sample& sample) { return sample.stamp >= stamp; });
    track.samples.erase(track.samples.begin(), first);
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [&](const Track& track) { return track.seen < stamp; }),
                tracks_.end());
}

}  // namespace bearing_calibration::core
