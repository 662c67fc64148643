#include "bearing_calibration/vision/light_detector.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/bearing_variance.h"

namespace bearing_calibration {
namespace {

// An evenly filled ellipse ends at two standard deviations; the window leaves room for the pixels'
// size. A Gaussian goes on further, and a spot of a pixel's width needs room for its pixels.
constexpr double kDiscWindow = 2.5;
constexpr double kGaussianWindow = 3.2;
constexpr double kMargin_px = 1.0;
// A disc has an inside when it is some pixels wide.
constexpr double kLeastDiscStddev_px = 1.5;
// Just outside the disc: if the mask cuts there, it cuts the light.
constexpr double kOutline = 2.1;

const DetectorConfig& validated(const DetectorConfig& config) {
  const std::vector<std::string> errors = config.validate();
  if (errors.empty()) return config;
  std::string message = "light detector:";
  for (const std::string& error : errors) message += "\n  - " + error;
  throw std::invalid_argument(message);
}

/// The thresholded pixels as an ellipse along the mirror's radius there.
LightEllipse ellipseFrom(const Blob& blob, const BlobShape& shape, const MirrorView& view) {
  const double u = shape.centre_u_px - view.centre_u_px;
  const double v = shape.centre_v_px - view.centre_v_px;
  const double square = std::max(u * u + v * v, std::numeric_limits<double>::min());
  LightEllipse ellipse;
  ellipse.radial_variance_px2 =
      (shape.variance_uu_px2 * u * u + 2.0 * shape.variance_uv_px2 * u * v +
       shape.variance_vv_px2 * v * v) /
      square;
  ellipse.tangential_variance_px2 =
      shape.variance_uu_px2 + shape.variance_vv_px2 - ellipse.radial_variance_px2;
  ellipse.centre_px = {shape.centre_u_px, shape.centre_v_px};
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
  ellipse->background_levels = spot.background.at_centre;
}

template <std::size_t count>
std::array<Eigen::Vector2d, count> directionsAllAround() {
  std::array<Eigen::Vector2d, count> directions;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * static_cast<double>(i) / static_cast<double>(count);
    directions[i] = {std::cos(angle), std::sin(angle)};
  }
  return directions;
}

/// The expected deviation that is nearest to a measured variance.
double stddevWithin(const Range& stddev_px, double variance_px2) {
  return std::clamp(std::sqrt(variance_px2), stddev_px.low, stddev_px.high);
}

}  // namespace

const Detection* likeliestLight(const std::vector<Detection>& lights) {
  const auto best = std::max_element(lights.begin(), lights.end(),
                                     [](const Detection& left, const Detection& right) {
                                       return left.bearing.quality < right.bearing.quality;
                                     });
  return best == lights.end() ? nullptr : &*best;
}

LightDetector::LightDetector(const DetectorConfig& config)
    : config_(validated(config)),
      mask_(config.mask, config.view, config.sensor),
      expected_(config),
      horizon_radius_px_(horizonRadiusPx(config.mirror)),
      sampler_(config.sensor.saturation_level) {
  region_.reserve(2 * mask_.intervals().size());
  result_.lights.reserve(static_cast<std::size_t>(config.max_candidates));
  result_.rejected.reserve(static_cast<std::size_t>(config.max_candidates));
}

const DetectionResult& LightDetector::detect(const cv::Mat& image,
                                             const std::optional<AzimuthSector>& region) {
  requireImage(image);
  const cv::Mat* searched = &image;
  if (config_.defocus_sigma_px > 0.0) {
    cv::GaussianBlur(image, defocused_, cv::Size(), config_.defocus_sigma_px);
    searched = &defocused_;
  }
  if (region) {
    mask_.clip(*region, &region_);
    scan(*searched, image, region_);
    result_.in_region = !result_.lights.empty();
    if (result_.in_region) return result_;
  }
  scan(*searched, image, mask_.intervals());
  result_.in_region = false;
  return result_;
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
                         const std::vector<PixelInterval>& intervals) {
  result_.lights.clear();
  result_.rejected.clear();
  result_.rejections.fill(0);
  result_.background = sampler_.measure(image, intervals);
  const ThresholdLadder ladder =
      thresholdsAbove(result_.background, config_.threshold, config_.sensor);
  for (std::size_t step = 0; step < ladder.size(); ++step) {
    result_.threshold_levels = ladder[step];
    const std::vector<Blob>& blobs = segmenter_.segment(image, intervals, ladder[step]);
    const bool first = step == 0;
    if (first) result_.too_cluttered = !segmenter_.complete();
    if (segmenter_.complete()) examine(image, sharp, blobs, first);
    if (!result_.lights.empty()) return;
  }
  result_.threshold_levels = ladder.front();  // of the rejections
}

void LightDetector::examine(const cv::Mat& image, const cv::Mat& sharp,
                            const std::vector<Blob>& blobs, bool with_rejected) {
  int measured = 0;
  for (const Blob& blob : blobs) {
    if (blob.pixels < config_.gates.min_pixels) continue;  // specks of noise
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
                            Detection* detection) const {
  const SpotWindow window = windowFor(shape);
  const SpotLevels levels{static_cast<double>(result_.threshold_levels),
                          config_.sensor.saturation_level, config_.sensor.black_level,
                          result_.background.median};
  const std::optional<SpotMeasurement> spot = measureSpot(
      image, sharp, window, levels, {config_.view.centre_u_px, config_.view.centre_v_px});
  if (!spot) {
    detection->rejection = Rejection::kNoLight;
    return;
  }
  takeOver(*spot, &detection->ellipse);
  if (window.weight == CentreWeight::kOutline) detection->ellipse.peakedness = spot->peakedness;
  detection->ellipse.saturated_fraction = saturatedFraction(config_, *spot);
  if (cutByMask({spot->centre_px, window.covariance_px2, kOutline})) {
    detection->rejection = Rejection::kMaskEdge;
    return;
  }
  const double radius_px =
      mirrorPixelFromImage(config_.view, spot->centre_px.x(), spot->centre_px.y()).image_radius_px;
  const SpotSize& expected = expected_.at(radius_px);
  detection->rejection =
      rejectionOf(detection->ellipse, radius_px, expected, horizon_radius_px_, config_);
  if (!detection->accepted()) return;
  const double quality = qualityOf(detection->ellipse, expected, config_);
  if (quality < config_.gates.min_quality) {
    detection->rejection = Rejection::kUnlikely;
    return;
  }
  const CentreVariance variance = centreVariance(config_, *spot, expected);
  detection->bearing = bearingFromEllipse(config_, detection->ellipse, variance, quality);
}

/// With the mirror's gates, the window lies along the mirror's radius and has a size that the
/// optics can make: clutter beside the light stays outside. Without them it follows the thresholded
/// pixels.
SpotWindow LightDetector::windowFor(const BlobShape& shape) const {
  SpotWindow window;
  window.centre_px = {shape.centre_u_px, shape.centre_v_px};
  window.covariance_px2 << shape.variance_uu_px2, shape.variance_uv_px2, shape.variance_uv_px2,
      shape.variance_vv_px2;
  window.size = kGaussianWindow;
  window.weight = CentreWeight::kEven;
  if (!config_.gates.mirror) return window;
  const Eigen::Vector2d from_centre =
      window.centre_px - Eigen::Vector2d(config_.view.centre_u_px, config_.view.centre_v_px);
  const SpotSize& expected = expected_.at(from_centre.norm());
  const Eigen::Vector2d outward = from_centre.normalized();
  const Eigen::Vector2d across(-outward.y(), outward.x());
  double radial =
      stddevWithin(expected.radial_stddev_px, outward.dot(window.covariance_px2 * outward));
  double tangential =
      stddevWithin(expected.tangential_stddev_px, across.dot(window.covariance_px2 * across));
  // What the lens defocuses is an evenly filled ellipse; all else is taken for a Gaussian.
  if (config_.defocus_sigma_px == 0.0 && std::min(radial, tangential) >= kLeastDiscStddev_px) {
    window.size = kDiscWindow;
    window.weight = CentreWeight::kOutline;
  } else {
    radial += kMargin_px / window.size;
    tangential += kMargin_px / window.size;
  }
  window.covariance_px2 = radial * radial * outward * outward.transpose() +
                          tangential * tangential * across * across.transpose();
  return window;
}

/// Whether the outline of the spot leaves the mask.
bool LightDetector::cutByMask(const SpotWindow& window) const {
  static const std::array<Eigen::Vector2d, 16> kDirections = directionsAllAround<16>();
  const Eigen::Matrix2d information = window.covariance_px2.inverse();
  for (const Eigen::Vector2d& direction : kDirections) {
    const double reach = window.size / std::sqrt(direction.dot(information * direction));
    const Eigen::Vector2d outline = window.centre_px + reach * direction;
    if (!mask_.contains(outline.x(), outline.y())) return true;
  }
  return false;
}

}  // namespace bearing_calibration
