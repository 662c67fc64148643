#include "bearing_calibration/vision/light_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration/vision/bearing_variance.h"

namespace bearing_calibration::core {
namespace {

// An evenly filled ellipse ends at two standard deviations; the window leaves room for the pixels'
// size. A Gaussian goes on further, and a spot of a pixel's width needs room for its pixels.
constexpr double kDiscWindow = 2.5;
constexpr double kGaussianWindow = 3.2;
constexpr double kMargin_px = 1.0;
// A disc has an inside when it is some pixels wide.
constexpr double kLeastDiscStddev_px = 1.5;
// By which the centre is off where a bright area beside the light was taken away: 0.02 to 0.16 px
// in cluttered scenes (doc/detection.md), 0.8 px where the area covers a pixel of the light's rim.
constexpr double kOpened_px = 0.3;
// Just outside the disc: if the mask cuts there, it cuts the light.
constexpr double kOutline = 2.1;

/// Nothing wider and higher than this is a light, unless that is a large one nearby.
cv::Mat elementFor(const DetectorConfig& config, const ExpectedSpot& expected) {
  if (!config.gates.mirror) return {};
  constexpr double kDiameter = 4.0;  // standard deviations from outline to outline
  const int largest = static_cast<int>(std::ceil(kDiameter * expected.largest_point_stddev_px()));
  const int side = largest + 2;
  return cv::getStructuringElement(cv::MORPH_RECT, {side, side});
}

DetectionResult emptyResult(std::size_t candidates) {
  DetectionResult result;
  result.lights.reserve(candidates);
  result.rejected.reserve(candidates);
  return result;
}

std::int64_t pixelsOf(const std::vector<PixelStrip>& strips) {
  std::int64_t pixels = 0;
  for (const PixelStrip& strip : strips) pixels += strip.end - strip.begin;
  return pixels;
}

Eigen::Vector2d mirrorCentre(const MirrorView& view) {
  return {view.centre_u_px, view.centre_v_px};
}

/// The thresholded pixels as an ellipse along the mirror's radius there.
LightEllipse ellipseFrom(const Blob& blob, const BlobShape& shape, const MirrorView& view) {
  const MirrorAxes axes(shape.centre_px, mirrorCentre(view));
  LightEllipse ellipse;
  ellipse.radial_variance_px2 = axes.radial.dot(shape.covariance_px2 * axes.radial);
  ellipse.tangential_variance_px2 = shape.covariance_px2.trace() - ellipse.radial_variance_px2;
  ellipse.centre_px = shape.centre_px;
  ellipse.fill = shape.fill;
  ellipse.fill_tolerance = fillTolerance(shape);
  ellipse.pixels =
      static_cast<int>(std::min<std::int64_t>(blob.pixels, std::numeric_limits<int>::max()));
  return ellipse;
}

void takeOver(const SpotMeasurement& spot, LightEllipse* ellipse) {
  ellipse->centre_px = spot.centre_px;
  ellipse->tangential_variance_px2 = spot.tangential.variance_px2;
  ellipse->radial_variance_px2 = spot.radial.variance_px2;
  ellipse->mixed_variance_px2 = spot.mixed_variance_px2;
  ellipse->mass_levels = spot.mass_levels;
  ellipse->peak_levels = spot.peak_levels;
  ellipse->background_levels = spot.background.plane.at_centre;
}

/// Whether a spot so refused may be a light all the same.
bool mayBeLitUnevenly(Rejection rejection) {
  return rejection == Rejection::kFill || rejection == Rejection::kKurtosis ||
         rejection == Rejection::kTangentialSize || rejection == Rejection::kRadialSize ||
         rejection == Rejection::kAxis || rejection == Rejection::kUnlikely;
}

/// By which the centre of a light is off if it is a part of one of these spots and this is the
/// light, unevenly lit: which of both is true, no image tells.
CentreVariance varianceAsPart(const Eigen::Vector2d& centre_px, const std::vector<Detection>& spots,
                              const MirrorView& view) {
  constexpr double kDisc2 = 4.0;  // squared standard deviations to the outline
  const MirrorAxes axes(centre_px, mirrorCentre(view));
  CentreVariance variance;
  for (const Detection& spot : spots) {
    if (!mayBeLitUnevenly(spot.rejection)) continue;
    const Eigen::Vector2d off = spot.ellipse.centre_px - centre_px;
    const double radial_px2 = std::pow(off.dot(axes.radial), 2);
    const double tangential_px2 = off.squaredNorm() - radial_px2;
    const double mahalanobis2 = radial_px2 / spot.ellipse.radial_variance_px2 +
                                tangential_px2 / spot.ellipse.tangential_variance_px2;
    if (mahalanobis2 > kDisc2) continue;
    variance += {tangential_px2, radial_px2};
  }
  return variance;
}

}  // namespace

const Detection* likeliestLight(const std::vector<Detection>& lights) {
  const auto best = std::max_element(lights.begin(), lights.end(),
                                     [](const Detection& left, const Detection& right) {
                                       return left.bearing.probability < right.bearing.probability;
                                     });
  return best == lights.end() ? nullptr : &*best;
}

LightDetector::LightDetector(const DetectorConfig& config)
    : config_(validated(config)),
      mask_(config.mask, config.view, config.sensor),
      expected_(config),
      largest_radius_px_(largestRadiusPx(config)),
      sampler_(config.sensor.saturation_level),
      wider_than_a_light_(elementFor(config, expected_)),
      mask_px_(pixelsOf(mask_.strips())),
      result_(emptyResult(static_cast<std::size_t>(config.max_candidates))),
      other_result_(emptyResult(static_cast<std::size_t>(config.max_candidates))) {
  region_.reserve(2 * mask_.strips().size());
  best_lights_.reserve(static_cast<std::size_t>(config.max_candidates));
}

const DetectionResult& LightDetector::detect(const cv::Mat& image,
                                             const std::optional<SearchRegion>& region) {
  requireImage(image);
  const cv::Mat* searched = &image;
  if (config_.defocus_sigma_px > 0.0) {
    cv::GaussianBlur(image, defocused_, cv::Size(), config_.defocus_sigma_px);
    searched = &defocused_;
  }
  result_.in_region = true;
  result_.opened = false;
  opened_is_of_image_ = false;
  if (region && region->place && config_.gates.mirror) {
    mask_.clipToBox(boxAround(*region->place, expected_, config_), &region_);
    scan(*searched, image, region_);
    if (!result_.lights.empty()) return result_;
  }
  if (region) {
    mask_.clipToSector(region->sector, &region_);
    scan(*searched, image, region_);
    if (!likely()) searchBesideBrightAreas(*searched, image, region_);
    if (!result_.lights.empty()) return result_;
  }
  result_.in_region = false;
  scan(*searched, image, mask_.strips());
  if (!likely()) searchBesideBrightAreas(*searched, image, mask_.strips());
  return result_;
}

/// A light that touches a window is no spot of its own at any threshold. An opening keeps what is
/// wider than a light; less that, the light stands alone. Where that shows none that is likelier,
/// the result is that of the image itself.
void LightDetector::searchBesideBrightAreas(const cv::Mat& image, const cv::Mat& sharp,
                                            const std::vector<PixelStrip>& strips) {
  if (!config_.gates.mirror) return;
  std::swap(result_, other_result_);
  if (!opened_is_of_image_) {
    cv::morphologyEx(image, opened_, cv::MORPH_TOPHAT, wider_than_a_light_);
    opened_is_of_image_ = true;
  }
  result_.in_region = other_result_.in_region;
  result_.opened = true;
  scan(opened_, sharp, strips);
  if (probabilityOfBest(result_) <= probabilityOfBest(other_result_)) {
    std::swap(result_, other_result_);
  }
}

double LightDetector::probabilityOfBest(const DetectionResult& result) {
  const Detection* best = likeliestLight(result.lights);
  return best == nullptr ? 0.0 : best->bearing.probability;
}

void LightDetector::requireImage(const cv::Mat& image) const {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) {
    throw std::invalid_argument("the detector takes grey images of 8 or 16 bits only");
  }
  if (image.cols != config_.sensor.width_px || image.rows != config_.sensor.height_px) {
    throw std::invalid_argument("the image is " + std::to_string(image.cols) + "x" +
                                std::to_string(image.rows) + ", but the mask is for " +
                                std::to_string(config_.sensor.width_px) + "x" +
                                std::to_string(config_.sensor.height_px));
  }
  if (image.depth() == CV_8U &&
      config_.sensor.saturation_level > std::numeric_limits<std::uint8_t>::max()) {
    throw std::invalid_argument("an 8-bit image cannot reach the saturation level " +
                                std::to_string(config_.sensor.saturation_level));
  }
}

void LightDetector::scan(const cv::Mat& image, const cv::Mat& sharp,
                         const std::vector<PixelStrip>& strips) {
  result_.lights.clear();
  result_.rejected.clear();
  result_.rejections.fill(0);
  best_lights_.clear();
  result_.background = sampler_.measure(image, strips);
  const ThresholdLadder ladder(result_.background, config_.threshold, config_.sensor);
  search_.opened = result_.opened;
  search_.log_part_searched = logPartOf(strips);
  double best = 0.0;
  for (int step = 0; step < ThresholdLadder::kSteps && best < kLikely; ++step) {
    const int threshold = ladder.at(step);
    const std::vector<Blob>& blobs = segmenter_.segment(image, strips, threshold);
    const bool first = step == 0;
    search_.threshold_levels = threshold;
    search_.thresholds = step + 1;
    if (first) result_.too_cluttered = !segmenter_.complete();
    result_.lights.clear();
    if (segmenter_.complete()) examine(image, sharp, blobs, first);
    if (!first && probabilityOfBest(result_) <= best) continue;
    best = probabilityOfBest(result_);
    result_.threshold_levels = threshold;
    std::swap(result_.lights, best_lights_);
  }
  std::swap(result_.lights, best_lights_);
}

/// The less of the mask is searched, the less of what is found there is clutter.
double LightDetector::logPartOf(const std::vector<PixelStrip>& strips) const {
  constexpr double kLeastPart = 0.05;  // clutter stands in groups
  const double part = static_cast<double>(pixelsOf(strips)) / static_cast<double>(mask_px_);
  return std::log(std::max(kLeastPart, part));
}

void LightDetector::examine(const cv::Mat& image, const cv::Mat& sharp,
                            const std::vector<Blob>& blobs, bool with_rejected) {
  const auto is_spot = [&](const Blob& blob) { return blob.pixels >= config_.gates.min_pixels; };
  search_.spots = static_cast<int>(std::count_if(blobs.begin(), blobs.end(), is_spot));
  int measured = 0;
  for (const Blob& blob : blobs) {
    if (!is_spot(blob)) continue;  // a speck of noise
    const BlobShape shape = shapeOf(blob);
    Detection detection;
    detection.ellipse = ellipseFrom(blob, shape, config_.view);
    detection.rejection = rejectionOf(blob, shape, config_.gates, expected_.area_px());
    if (detection.accepted() && measured++ < config_.max_candidates) {
      measure(image, sharp, shape, &detection);
    } else if (detection.accepted()) {
      detection.rejection = Rejection::kTooManySpots;
    }
    if (detection.accepted()) {
      result_.lights.push_back(detection);
    } else if (with_rejected) {
      listRejected(detection);
    }
  }
}

void LightDetector::listRejected(const Detection& detection) {
  ++result_.rejections[static_cast<std::size_t>(detection.rejection)];
  const std::size_t most = static_cast<std::size_t>(config_.max_candidates);
  if (result_.rejected.size() < most) result_.rejected.push_back(detection);
}

void LightDetector::measure(const cv::Mat& image, const cv::Mat& sharp, const BlobShape& shape,
                            Detection* detection) {
  const SpotWindow window = windowFor(shape);
  const SpotLevels levels{search_.threshold_levels, result_.background.median,
                          levelNoise(config_.sensor)};
  const std::optional<SpotMeasurement> spot =
      measureSpot(image, sharp, window, levels, mirrorCentre(config_.view));
  if (!spot) {
    detection->rejection = Rejection::kNoLight;
    return;
  }
  takeOver(*spot, &detection->ellipse);
  if (window.weight == CentreWeight::kOutline) detection->ellipse.kurtosis = spot->kurtosis;
  detection->ellipse.saturated_fraction = saturatedFraction(config_, *spot);
  if (cutByMask({spot->centre_px, window.covariance_px2, kOutline})) {
    detection->rejection = Rejection::kMaskEdge;
    return;
  }
  const MirrorPixel seen =
      mirrorPixelFromImage(config_.view, spot->centre_px.x(), spot->centre_px.y());
  const SpotSize& expected = expected_.at(seen.image_radius_px);
  if (config_.gates.mirror && seen.image_radius_px > largest_radius_px_) {
    detection->rejection = Rejection::kHorizon;
    return;
  }
  const Doubts doubts = doubtsAbout(detection->ellipse, expected, search_, config_.gates);
  const double probability = probabilityOf(doubts, search_);
  if (probability < config_.gates.min_probability) {
    detection->rejection = largestOf(doubts);
    return;
  }
  CentreVariance variance = centreVariance(config_, *spot, expected);
  if (result_.opened) variance += {kOpened_px * kOpened_px, kOpened_px * kOpened_px};
  if (search_.thresholds > 1) {
    variance += varianceAsPart(spot->centre_px, result_.rejected, config_.view);
  }
  detection->bearing = bearingFromPixel(config_, seen, variance, probability);
}

/// With the mirror's gates, the window lies along the mirror's radius and has a size that the
/// optics can make: clutter beside the light stays outside. Without them it follows the thresholded
/// pixels.
SpotWindow LightDetector::windowFor(const BlobShape& shape) const {
  SpotWindow window{{shape.centre_px, shape.covariance_px2, kGaussianWindow}, CentreWeight::kEven};
  if (!config_.gates.mirror) return window;
  const Eigen::Vector2d mirror_centre = mirrorCentre(config_.view);
  const MirrorAxes axes(shape.centre_px, mirror_centre);
  const SpotSize& expected = expected_.at((shape.centre_px - mirror_centre).norm());
  const auto stddev = [&](const Eigen::Vector2d& axis, const Range& usual, const Range& allowed) {
    constexpr double kByThreshold = 1.03;  // a bright spot gains a pixel all round
    const double seen = std::sqrt(axis.dot(shape.covariance_px2 * axis));
    const double likely = std::clamp(seen, usual.low, usual.high);
    const double near = std::clamp(likely, seen / kByThreshold, seen * kByThreshold);
    return std::clamp(near, allowed.low, allowed.high);
  };
  double radial = stddev(axes.radial, expected.radial_stddev_px, expected.possibleRadial_px());
  double tangential =
      stddev(axes.tangential, expected.tangential_stddev_px, expected.possibleTangential_px());
  // What the lens defocuses is an evenly filled ellipse; all else is taken for a Gaussian.
  if (config_.defocus_sigma_px == 0.0 && std::min(radial, tangential) >= kLeastDiscStddev_px) {
    window.size = kDiscWindow;
    window.weight = CentreWeight::kOutline;
  } else {
    radial += kMargin_px / window.size;
    tangential += kMargin_px / window.size;
  }
  window.covariance_px2 = axes.covariance(radial * radial, tangential * tangential);
  return window;
}

/// Whether the outline of the spot leaves the mask.
bool LightDetector::cutByMask(const PixelEllipse& window) const {
  constexpr double kRounding_px = 1.5;
  const double longest_reach_px = window.size * std::sqrt(window.covariance_px2.trace());
  if (mask_.clearancePx(window.centre_px.x(), window.centre_px.y()) >
      longest_reach_px + kRounding_px) {
    return false;
  }
  constexpr int kDirections = 16;
  const Eigen::Matrix2d information = window.covariance_px2.inverse();
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * kPi * i / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    const double reach = window.size / std::sqrt(direction.dot(information * direction));
    const Eigen::Vector2d outline = window.centre_px + reach * direction;
    if (!mask_.contains(outline.x(), outline.y())) return true;
  }
  return false;
}

}  // namespace bearing_calibration::core
