#include "bearing_calibration/vision/image_advice.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

// A quarter of the pixels full: a little more light, and only the spot's outline tells its place.
constexpr double kMuchSaturated = 0.25;
// Of the levels above black: a light that uses less is read worse than it could be, and the
// threshold is near.
constexpr double kDimPart = 0.2;
// Leaves room for a light twice as near.
constexpr double kGoodPart = 0.7;
// A spot that may be the light out of focus is round enough: wider than the gates.
constexpr double kLeastRoundFill = 0.8;
constexpr double kMostRoundFill = 1.15;

// A spot that differs more from a point light's is another focus' rather.
constexpr double kOutOfFocus = 0.25;

using Eigen::Array2d;  // (tangential, radial)

Array2d stddevsOf(const LightEllipse& ellipse) { return ellipse.variances_px2().cwiseSqrt(); }

double imageRadiusOf(const DetectorConfig& config, const LightEllipse& ellipse) {
  return (ellipse.centre_px - config.view.centre_px()).norm();
}

SpotSize expectedSize(const DetectorConfig& config, const LightEllipse& ellipse) {
  return spotSizeAt(config, imageRadiusOf(config, ellipse));
}

/// The spot's two deviations beside those that the configured lens makes: how many times the one
/// that fits less is too large, or too small, less one.
double misfitOf(const DetectorConfig& config, const LightEllipse& ellipse) {
  const SpotSize expected = expectedSize(config, ellipse);
  const Array2d too_large = stddevsOf(ellipse) / expected.most_stddev_px.array();
  const Array2d too_small = expected.least_stddev_px.array() / stddevsOf(ellipse);
  return too_large.max(too_small).max(1.0).maxCoeff() - 1.0;
}

std::string distanceText(double distance_m) {
  return std::isfinite(distance_m) ? formatted("%.2f m", distance_m) : "far away";
}

Advice focusAdvice(const DetectorConfig& config, const LightEllipse& ellipse,
                   const FocusGuess& guess) {
  const SpotSize expected = expectedSize(config, ellipse);
  // An evenly filled ellipse is four standard deviations wide.
  const Array2d seen_px = 4.0 * stddevsOf(ellipse);
  const Array2d expected_px = 2.0 * (expected.least_stddev_px + expected.most_stddev_px);
  const double configured_m = config.mirror.focus_distance_m;
  const char* where = guess.focus_distance_m > configured_m ? "nearer" : "farther";
  return {
      AdviceKind::kFocus,
      formatted("no spot has the light's size, but one of %.0f x %.0f px (along azimuth x "
                "radius) instead of %.0f x %.0f is as a lens focused %s would show it: focus %s, "
                "or correct lens/focus_distance (%s)",
                seen_px(0), seen_px(1), expected_px(0), expected_px(1),
                distanceText(guess.focus_distance_m).c_str(), where,
                distanceText(configured_m).c_str())};
}

std::optional<Advice> onExposure(const ImageSensor& sensor, const LightEllipse& ellipse) {
  const double black = sensor.black_level;
  const double levels = sensor.saturation_level - black;
  const double wanted = kGoodPart * levels;
  const double background = std::max(0.0, ellipse.background_levels - black);
  const double contrast = ellipse.peak_levels - ellipse.background_levels;
  if (ellipse.saturated_fraction > kMuchSaturated) {
    constexpr double kPercent = 100.0;
    return Advice{AdviceKind::kSaturated,
                  formatted("the light is saturated (%.0f %% of its pixels are full): shorten the "
                            "exposure or lower the gain until it peaks at about %.0f levels",
                            kPercent * ellipse.saturated_fraction, wanted + black)};
  }
  if (contrast >= kDimPart * levels) return std::nullopt;
  const double longer = wanted / (background + contrast);
  if (longer < 2.0) {
    return Advice{AdviceKind::kDim,
                  formatted("the light stands only %.0f levels over a background of %.0f: make it "
                            "stronger, or darken what is behind it; no exposure helps",
                            contrast, ellipse.background_levels)};
  }
  return Advice{AdviceKind::kDim,
                formatted("the light is dim (%.0f levels over the background, of %.0f): lengthen "
                          "the exposure, or raise the gain, about %.0f times",
                          contrast, levels, longer)};
}

/// Whether another focus may be all that keeps the spot from being the light.
bool mayBeOutOfFocus(const DetectorConfig& config, const Detection& spot) {
  const LightEllipse& ellipse = spot.ellipse;
  const bool round = ellipse.fill > kLeastRoundFill - ellipse.fill_tolerance &&
                     ellipse.fill < kMostRoundFill + ellipse.fill_tolerance;
  return config.mirror_kind == MirrorKind::kCone && spot.rejection != Rejection::kMaskEdge &&
         round && imageRadiusOf(config, ellipse) <= largestLightRadiusPx(config) &&
         misfitOf(config, ellipse) > kOutOfFocus;
}

/// No light, but bright spots: if one of them is as the light would be at another focus, this is
/// the likeliest reason.
Advice onRejected(const DetectorConfig& config, const DetectionResult& result) {
  constexpr int kMostGuesses = 10;  // each takes 0.1 ms; so many round spots are clutter
  int guesses = 0;
  const Detection* likeliest = nullptr;
  FocusGuess best{0.0, kOutOfFocus};
  for (const Detection& spot : result.rejected) {
    if (!mayBeOutOfFocus(config, spot) || guesses++ >= kMostGuesses) continue;
    const FocusGuess guess = guessFocus(config, spot.ellipse);
    if (guess.misfit > best.misfit) continue;
    best = guess;
    likeliest = &spot;
  }
  if (likeliest != nullptr) return focusAdvice(config, likeliest->ellipse, best);
  const auto commonest = std::max_element(result.rejections.begin(), result.rejections.end());
  return {AdviceKind::kNoneFits,
          formatted("bright spots, but none is like the light (commonest: %s): compare ~annotated "
                    "with what is there",
                    describe(static_cast<Rejection>(commonest - result.rejections.begin())))};
}

}  // namespace

FocusGuess guessFocus(const DetectorConfig& config, const LightEllipse& ellipse) {
  constexpr int kSteps = 60;  // even in 1 / distance, as the blur is
  // From infinity to half of the way to the mirror, or twice as near as configured: beyond, a
  // light fills the mirror.
  const double most_per_m =
      2.0 / std::min(config.mirror.focus_distance_m, config.mirror.lens_to_apex_m);
  const double step_per_m = std::min(most_per_m, 0.5 / config.mirror.focal_length_m) / kSteps;
  FocusGuess best{config.mirror.focus_distance_m, misfitOf(config, ellipse)};
  for (int step = 0; step <= kSteps; ++step) {
    DetectorConfig other = config;
    other.mirror.focus_distance_m = 1.0 / (step * step_per_m);  // infinity first
    const double misfit = misfitOf(other, ellipse);
    if (misfit < best.misfit) best = {other.mirror.focus_distance_m, misfit};
  }
  return best;
}

std::optional<Advice> adviceFor(const DetectorConfig& config, const DetectionResult& result) {
  if (const Detection* light = likeliestLight(result.lights)) {
    return onExposure(config.sensor, light->ellipse);
  }
  if (result.too_cluttered) {
    return Advice{AdviceKind::kTooCluttered,
                  "too many bright spots: shorten the exposure, or raise threshold/min_contrast"};
  }
  if (result.rejected.empty()) {
    return Advice{AdviceKind::kNothingBright,
                  formatted("nothing stands out of the background (%.0f levels, threshold %d): is "
                            "the light on and in view? if so, lengthen the exposure",
                            result.background.median, result.threshold_levels)};
  }
  return onRejected(config, result);
}

void AdviceTally::add(const std::optional<Advice>& advice) {
  ++images_;
  if (!advice) return;
  const std::size_t kind = static_cast<std::size_t>(advice->kind);
  ++counts_[kind];
  sentences_[kind] = advice->sentence;
}

std::optional<Advice> AdviceTally::take() {
  const auto most = std::max_element(counts_.begin(), counts_.end());
  std::optional<Advice> advice;
  if (*most > 0 && 2 * *most >= images_) {
    const std::size_t kind = static_cast<std::size_t>(most - counts_.begin());
    advice = Advice{static_cast<AdviceKind>(kind), sentences_[kind]};
  }
  *this = AdviceTally();
  return advice;
}

}  // namespace bearing_calibration::core
