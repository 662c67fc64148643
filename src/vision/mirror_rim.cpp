#include "bearing_calibration/vision/mirror_rim.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/robust_statistics.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

/// An image in which edges are looked for.
struct EdgeImage {
  EdgeImage(const cv::Mat& image, double saturation_level);

  bool nearFullPixel(const Vector2d& place_px) const;

  cv::Mat smooth;      ///< CV_32FC1
  cv::Mat near_full;   ///< CV_8UC1, not 0 so near a full pixel that clipping moves an edge
  double least_slope;  ///< [levels/px] of an edge: it stands over the image's noise and texture
};

/// Where the brightness changes fastest along a ray.
struct RayEdge {
  int ray = 0;
  Vector2d place_px = Vector2d::Zero();  ///< (u, v), a fraction of a pixel
  double slope = 0.0;                    ///< size of the change [levels/px]
};

// One ray in four pixels of a usual rim: neighbours share little of their noise.
constexpr int kRays = 360;

/// Median slope of the image along its rows, from a grid of its pixels.
double usualSlope(const cv::Mat& smooth) {
  constexpr int kStep = 5;
  std::vector<double> slopes;
  for (int v = 0; v < smooth.rows; v += kStep) {
    const float* row = smooth.ptr<float>(v);
    for (int u = 1; u + 1 < smooth.cols; u += kStep) {
      slopes.push_back(static_cast<double>(0.5F * std::abs(row[u + 1] - row[u - 1])));
    }
  }
  return slopes.empty() ? 0.0 : medianOf(std::move(slopes));
}

EdgeImage::EdgeImage(const cv::Mat& image, double saturation_level) {
  constexpr double kSmoothing_px = 1.5;  // narrow beside a lens' defocus, wide beside a pixel
  image.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, cv::Size(), kSmoothing_px);
  constexpr double kRounding = 0.01;        // [levels/px] of a perfectly even image
  constexpr double kSlopesOverUsual = 4.0;  // most of an image has no edge
  least_slope = std::max(kRounding, kSlopesOverUsual * usualSlope(smooth));
  constexpr int kFullReach_px = 7;  // half of a defocused edge and the smoothing
  constexpr int kSide_px = 2 * kFullReach_px + 1;
  cv::dilate(image >= saturation_level, near_full, cv::Mat::ones(kSide_px, kSide_px, CV_8U));
}

bool EdgeImage::nearFullPixel(const Vector2d& place_px) const {
  const int u = std::clamp(cvRound(place_px.x()), 0, near_full.cols - 1);
  const int v = std::clamp(cvRound(place_px.y()), 0, near_full.rows - 1);
  return near_full.at<std::uint8_t>(v, u) != 0;
}

/// Where between its neighbours the parabola through three slopes is highest, from the middle one.
double topOf(double before, double middle, double after) {
  const double bend = before - 2.0 * middle + after;
  return bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
}

/// Slopes at every pixel of a ray, from that on as far as it lies in the image; 0 at both ends.
std::vector<double> slopesAlong(const cv::Mat& smooth, const Vector2d& begin_px,
                                const Vector2d& direction, double length_px) {
  const cv::Rect2d image(0.0, 0.0, smooth.cols - 1.0, smooth.rows - 1.0);
  std::vector<double> levels;
  cv::Mat1f level;  // between pixels
  for (double distance_px = 0.0; distance_px <= length_px; distance_px += 1.0) {
    const Vector2d place_px = begin_px + distance_px * direction;
    const cv::Point2d place(place_px.x(), place_px.y());
    if (!image.contains(place)) break;
    cv::getRectSubPix(smooth, {1, 1}, place, level);
    levels.push_back(level(0, 0));
  }
  std::vector<double> slopes(levels.size(), 0.0);
  for (std::size_t i = 1; i + 1 < levels.size(); ++i) {
    slopes[i] = 0.5 * std::abs(levels[i + 1] - levels[i - 1]);
  }
  return slopes;
}

/// The at most `most_per_ray` steepest edges, in this range from the centre, of each of the rays
/// all around it, by ray.
std::vector<RayEdge> edgesAround(const Vector2d& centre_px, const Range& range_px,
                                 const EdgeImage& image, std::size_t most_per_ray) {
  const double begin_px = std::max(0.0, range_px.low);
  std::vector<RayEdge> edges;
  for (int ray = 0; ray < kRays; ++ray) {
    const double angle = 2.0 * kPi * ray / kRays;
    const Vector2d direction(std::cos(angle), std::sin(angle));
    const std::vector<double> slopes = slopesAlong(image.smooth, centre_px + begin_px * direction,
                                                   direction, range_px.high - begin_px);
    std::vector<RayEdge> of_ray;
    for (std::size_t i = 1; i + 1 < slopes.size(); ++i) {
      const bool top = slopes[i] >= slopes[i - 1] && slopes[i] > slopes[i + 1];
      if (!top || slopes[i] < image.least_slope) continue;
      const double distance_px =
          begin_px + static_cast<double>(i) + topOf(slopes[i - 1], slopes[i], slopes[i + 1]);
      const Vector2d place = centre_px + distance_px * direction;
      if (!image.nearFullPixel(place)) of_ray.push_back({ray, place, slopes[i]});
    }
    std::sort(of_ray.begin(), of_ray.end(),
              [](const RayEdge& left, const RayEdge& right) { return left.slope > right.slope; });
    of_ray.resize(std::min(of_ray.size(), most_per_ray));
    edges.insert(edges.end(), of_ray.begin(), of_ray.end());
  }
  return edges;
}

/// Rays of which an edge lies on the circle.
int supportOf(const Circle& circle, const std::vector<RayEdge>& edges) {
  constexpr double kNear_px = 2.0;
  int rays = 0;
  int last_ray = -1;
  for (const RayEdge& edge : edges) {
    if (edge.ray == last_ray) continue;
    const double distance_px = (edge.place_px - circle.centre_px).norm();
    if (std::abs(distance_px - circle.radius_px) > kNear_px) continue;
    ++rays;
    last_ray = edge.ray;
  }
  return rays;
}

bool allowed(const Circle& circle, const RimSearch& search) {
  return (circle.centre_px - search.centre_px).norm() <= search.max_centre_error_px &&
         circle.radius_px >= search.radius_px.low && circle.radius_px <= search.radius_px.high;
}

/// The circle through three edges that has the longest edge.
std::optional<Circle> likeliestCircle(const EdgeImage& image, const RimSearch& search) {
  constexpr std::size_t kMostPerRay = 6;  // the rim is among the steepest of a ray
  // When half of the rays show the rim, as one edge of six, a thousandth of the triples is right.
  constexpr int kTriples = 20000;
  constexpr unsigned kSeed = 1;
  const Range range_px{search.radius_px.low - search.max_centre_error_px,
                       search.radius_px.high + search.max_centre_error_px};
  const std::vector<RayEdge> edges = edgesAround(search.centre_px, range_px, image, kMostPerRay);
  if (edges.empty()) return std::nullopt;
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<std::size_t> pick(0, edges.size() - 1);
  std::optional<Circle> best;
  double longest_px = 0.0;
  for (int i = 0; i < kTriples; ++i) {
    const auto circle = circleThrough(edges[pick(random)].place_px, edges[pick(random)].place_px,
                                      edges[pick(random)].place_px);
    if (!circle || !allowed(*circle, search)) continue;
    const double length_px = circle->radius_px * supportOf(*circle, edges);
    if (length_px <= longest_px) continue;
    longest_px = length_px;
    best = circle;
  }
  return best;
}

/// Fits the circle to the edges near it, on rays from its own centre.
std::optional<MirrorRim> refine(const EdgeImage& image, const Circle& first) {
  constexpr double kReaches_px[] = {8.0, 5.0, 5.0};  // either side of the circle
  CircleFit rim;
  rim.circle = first;
  for (double reach_px : kReaches_px) {
    const Range near_px{rim.circle.radius_px - reach_px, rim.circle.radius_px + reach_px};
    std::vector<Vector2d> places;
    for (const RayEdge& edge : edgesAround(rim.circle.centre_px, near_px, image, 1)) {
      places.push_back(edge.place_px);
    }
    const std::optional<CircleFit> fit = fitCircle(places, rim.circle);
    if (!fit) return std::nullopt;
    rim = *fit;
  }
  return MirrorRim{rim, static_cast<double>(rim.points_px.size()) / kRays};
}

void require(const cv::Mat& image, const RimSearch& search) {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) {
    throw std::invalid_argument("the rim is searched in grey images of 8 or 16 bits only");
  }
  if (image.empty()) throw std::invalid_argument("there is no rim in an empty image");
  const bool possible = search.centre_px.allFinite() && search.max_centre_error_px >= 0.0 &&
                        search.radius_px.low > 0.0 &&
                        search.radius_px.high >= search.radius_px.low &&
                        std::isfinite(search.radius_px.high + search.max_centre_error_px);
  if (!possible) throw std::invalid_argument("no circle lies in the search for the mirror's rim");
}

void say(bool fits, const std::string& sentence, MirrorCheck* check) {
  check->consistent = check->consistent && fits;
  check->sentences.push_back(sentence);
}

void checkCentre(const MirrorRim& rim, const DetectorConfig& config, MirrorCheck* check) {
  constexpr double kFalseAlarms = 1e-3;  // of checks of a centre that is right
  const Vector2d configured = config.view.centre_px();
  const Vector2d departure = rim.circle.centre_px - configured;
  const Eigen::Matrix2d covariance =
      rim.covariance_px2.topLeftCorner<2, 2>() +
      std::pow(config.alignment.centre_stddev_px, 2) * Eigen::Matrix2d::Identity();
  // Of two degrees of freedom, chi-square exceeds x with the probability exp(-x / 2).
  const bool fits =
      departure.dot(covariance.inverse() * departure) <= -2.0 * std::log(kFalseAlarms);
  say(fits,
      formatted(
          "the rim's centre is (%.2f +- %.2f, %.2f +- %.2f) px, mirror/centre_u and centre_v are "
          "(%.2f, %.2f): %s",
          rim.circle.centre_px.x(), rim.stddev(0), rim.circle.centre_px.y(), rim.stddev(1),
          configured.x(), configured.y(),
          fits ? "they agree" : "set them to the rim's centre, or raise alignment/centre_stddev"),
      check);
}

void checkRadius(const MirrorRim& rim, const DetectorConfig& config, MirrorCheck* check) {
  // Focal length and distances are known to some percent; beyond, the horizon and the expected
  // sizes are off by as much, and the gates that lean on them refuse lights.
  constexpr double kRimTolerance = 0.03;
  const double expected_px = rimRadiusPx(config.mirror);
  const bool fits = std::abs(rim.circle.radius_px / expected_px - 1.0) <= kRimTolerance;
  say(fits,
      formatted("the rim's radius is %.2f +- %.2f px, lens and mirror put it at %.2f px: %s",
                rim.circle.radius_px, rim.stddev(2), expected_px,
                fits ? "they agree"
                     : "check lens/focal_length, lens/focus_distance, lens/pixel_pitch, "
                       "mirror/lens_to_apex, mirror/half_angle and mirror/base_radius"),
      check);
}

}  // namespace

RimSearch rimSearchAround(const DetectorConfig& config) {
  constexpr double kError = 0.25;  // of centre and radius, by the radius: they are known better
  const double radius_px = rimRadiusPx(config.mirror);
  return {config.view.centre_px(),
          kError * radius_px,
          {(1.0 - kError) * radius_px, (1.0 + kError) * radius_px},
          config.sensor.saturation_level};
}

RimSearch rimSearchIn(const cv::Mat& image) {
  // A mirror's image takes a good part of the picture, and may be cut at two of its sides.
  constexpr double kCentreError = 0.2;
  constexpr double kSmallest = 0.2;
  constexpr double kLargest = 0.6;
  const double side_px = std::min(image.cols, image.rows);
  const double full = image.depth() == CV_8U ? std::numeric_limits<std::uint8_t>::max()
                                             : std::numeric_limits<std::uint16_t>::max();
  return {{0.5 * (image.cols - 1), 0.5 * (image.rows - 1)},
          kCentreError * side_px,
          {kSmallest * side_px, kLargest * side_px},
          full};
}

std::optional<MirrorRim> findMirrorRim(const cv::Mat& image, const RimSearch& search) {
  require(image, search);
  constexpr double kLeastVisiblePart = 1.0 / 3.0;
  const EdgeImage edges(image, search.saturation_level);
  const std::optional<Circle> first = likeliestCircle(edges, search);
  if (!first) return std::nullopt;
  const std::optional<MirrorRim> rim = refine(edges, *first);
  const bool seen = rim && rim->visible_part >= kLeastVisiblePart && allowed(rim->circle, search);
  return seen ? rim : std::nullopt;
}

MirrorCheck checkMirror(const MirrorRim& rim, const DetectorConfig& config) {
  MirrorCheck check;
  checkCentre(rim, config, &check);
  if (config.mirror_kind == MirrorKind::kCone) checkRadius(rim, config, &check);
  constexpr double kSlack_px = 1.0;  // a mask is cut at whole pixels
  if (config.mask.outer_radius_px > rim.circle.radius_px + kSlack_px) {
    say(false,
        formatted("mask/outer_radius is %.1f px and reaches past the rim: set it to %.1f",
                  config.mask.outer_radius_px, std::floor(rim.circle.radius_px)),
        &check);
  }
  return check;
}

}  // namespace bearing_calibration::core
