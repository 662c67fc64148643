#include "bearing_calibration/vision/light_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

double pixelsOf(const std::vector<PixelStrip>& strips) {
  std::int64_t pixels = 0;
  for (const PixelStrip& strip : strips) pixels += strip.end - strip.begin;
  return static_cast<double>(pixels);
}

double probabilityOfBest(const std::vector<Detection>& lights) {
  const Detection* best = likeliestLight(lights);
  return best == nullptr ? 0.0 : best->bearing.probability;
}

void requireImage(const cv::Mat& image, const ImageSensor& sensor) {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) {
    throw std::invalid_argument("the detector takes grey images of 8 or 16 bits only");
  }
  if (image.cols != sensor.width_px || image.rows != sensor.height_px) {
    throw std::invalid_argument(formatted("the image is %dx%d, but the mask is for %dx%d",
                                          image.cols, image.rows, sensor.width_px,
                                          sensor.height_px));
  }
  if (image.depth() == CV_8U &&
      sensor.saturation_level > std::numeric_limits<std::uint8_t>::max()) {
    throw std::invalid_argument("an 8-bit image cannot reach the saturation level " +
                                std::to_string(sensor.saturation_level));
  }
}

}  // namespace

LightDetector::LightDetector(const DetectorConfig& config)
    : config_(validated(config)), mask_(config), mask_px_(pixelsOf(mask_.strips())) {
  if (config.mirror_kind == MirrorKind::kCone) {
    expected_ = std::make_unique<ExpectedSpot>(config);
    // Nothing wider and higher than this is a light, unless that is a large one nearby.
    constexpr double kDiameter = 4.0;  // standard deviations from outline to outline
    const double largest_px = std::ceil(kDiameter * expected_->largestPointStddev_px());
    const int side = static_cast<int>(largest_px) + 2;
    wider_than_a_light_ = cv::getStructuringElement(cv::MORPH_RECT, {side, side});
  }
}

const DetectionResult& LightDetector::detect(const cv::Mat& image,
                                             const std::optional<SearchRegion>& region) {
  requireImage(image, config_.sensor);
  if (config_.mirror_kind == MirrorKind::kNone && !config_.camera) {
    throw std::invalid_argument("the detector does not know its camera's rays yet");
  }
  const bool defocus = config_.defocus_sigma_px > 0.0;
  if (defocus) cv::GaussianBlur(image, defocused_, cv::Size(), config_.defocus_sigma_px);
  const SearchedImage searched{defocus ? defocused_ : image, image};
  opened_is_of_image_ = false;
  bool found = false;
  if (region && region->place && expected_) {
    mask_.clipToBox(boxAround(*region->place, *expected_, config_), &region_);
    scan(searched, region_, false, &result_);
    found = probabilityOfBest(result_.lights) >= kLikely;
  }
  if (region && !found) {
    mask_.clipToSector(region->sector, &region_);
    search(searched, region_);
    found = probabilityOfBest(result_.lights) >= kLikely;
  }
  if (!found) search(searched, mask_.strips());
  result_.in_region = found;
  return result_;
}

/// A light that touches a window is no spot of its own at any threshold. An opening keeps what is
/// wider than a light; less that, the light stands alone. Where that shows none that is likelier,
/// the result is that of the image itself.
void LightDetector::search(const SearchedImage& image, const std::vector<PixelStrip>& strips) {
  scan(image, strips, false, &result_);
  const double probability = probabilityOfBest(result_.lights);
  if (probability >= kLikely || !expected_) return;
  if (!opened_is_of_image_) {
    cv::morphologyEx(image.levels, opened_, cv::MORPH_TOPHAT, wider_than_a_light_);
    opened_is_of_image_ = true;
  }
  scan({opened_, image.sensed}, strips, true, &opened_result_);
  if (probabilityOfBest(opened_result_.lights) > probability) std::swap(result_, opened_result_);
}

/// One threshold after the other until a spot is likely by itself; the lights are those of the best
/// one.
void LightDetector::scan(const SearchedImage& image, const std::vector<PixelStrip>& strips,
                         bool opened, DetectionResult* result) {
  constexpr double kLeastPart = 0.05;  // clutter stands in groups
  result->lights.clear();
  result->rejected.clear();
  result->rejections.fill(0);
  result->opened = opened;
  result->background = backgroundOf(image.levels, strips, config_.sensor.saturation_level);
  result->part_searched = std::max(kLeastPart, pixelsOf(strips) / mask_px_);
  Search search;
  search.part_searched = result->part_searched;
  search.opened = opened;
  search.background_levels = result->background.median;
  // as much as kLikely, were all of the mask searched
  const double enough = kLikely / (kLikely + search.part_searched * (1.0 - kLikely));
  double best = 0.0;
  for (int threshold : thresholdsOver(result->background, config_.threshold, config_.sensor)) {
    const std::vector<Blob>& blobs =
        segmenter_.segment(image.levels, strips, threshold, config_.gates.min_pixels);
    const bool first = search.thresholds++ == 0;
    search.threshold_levels = threshold;
    search.spots = static_cast<int>(blobs.size());
    if (first) result->too_cluttered = !segmenter_.complete();
    examine(image, blobs, search, result);
    const double probability = probabilityOfBest(lights_);
    if (!first && probability <= best) continue;
    best = probability;
    result->threshold_levels = threshold;
    std::swap(result->lights, lights_);
    if (best >= enough) break;
  }
}

void LightDetector::examine(const SearchedImage& image, const std::vector<Blob>& blobs,
                            const Search& search, DetectionResult* result) {
  const std::size_t most = static_cast<std::size_t>(config_.max_candidates);
  std::size_t measured = 0;
  lights_.clear();
  for (const Blob& blob : blobs) {
    Detection spot;
    spot.ellipse = ellipseOf(blob, config_.view.centre_px());
    spot.rejection = rejectionOf(spot.ellipse, config_.gates, expected_.get());
    if (spot.accepted()) {
      spot.rejection = measured++ < most ? measure(image, search, result->rejected, &spot)
                                         : Rejection::kTooManySpots;
    }
    if (spot.accepted()) {
      lights_.push_back(spot);
    } else if (search.thresholds == 1) {
      ++result->rejections[static_cast<std::size_t>(spot.rejection)];
      if (result->rejected.size() < most) result->rejected.push_back(spot);
    }
  }
}

/// From a spot's thresholded pixels to its bearing. @return why it is refused, or kNone
Rejection LightDetector::measure(const SearchedImage& image, const Search& search,
                                 const std::vector<Detection>& refused, Detection* spot) const {
  const SpotWindow window = windowFor(spot->ellipse, expected_.get(), config_);
  const std::optional<LightEllipse> light =
      measureSpot(image, spot->ellipse, window, search, config_);
  if (!light) return Rejection::kNoLight;
  spot->ellipse = *light;
  constexpr double kOutline = 2.1;  // just outside the disc: what cuts there cuts the light
  if (mask_.cuts({light->centre_px, window.covariance_px2, kOutline})) return Rejection::kMaskEdge;
  if (expected_ && !expected_->mayStandAt(light->centre_px)) return Rejection::kHorizon;
  const LightProbability probability = probabilityOf(*light, expected_.get(), search);
  if (probability.value < config_.gates.min_probability) return probability.doubt;
  const std::optional<Bearing> bearing =
      bearingOf(*light, search, refused, expected_.get(), config_);
  if (!bearing) return Rejection::kNoRay;
  spot->bearing = *bearing;
  spot->bearing.probability = probability.value;
  return Rejection::kNone;
}

}  // namespace bearing_calibration::core
