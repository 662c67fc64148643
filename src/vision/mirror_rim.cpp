#include "bearing_calibration/vision/mirror_rim.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <random>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

/// Rays from a point of an image, evenly all around, and the part of each that is looked at.
struct RayFan {
  Vector2d centre_px = Vector2d::Zero();
  int rays = 0;
  double begin_px = 0.0;
  double end_px = 0.0;
};

/// Where the brightness changes fastest along a ray.
struct RayEdge {
  int ray = 0;
  Vector2d place_px = Vector2d::Zero();  ///< (u, v), a fraction of a pixel
  double slope = 0.0;                    ///< size of the change [levels/px]
};

/// Finds edges along rays, between pixels, in an image smoothed for it once.
class RayEdgeFinder {
 public:
  /// @param image CV_8UC1 or CV_16UC1. @param saturation_level an edge beside a pixel of this level
  ///   or more is left out: its place depends on what was clipped.
  RayEdgeFinder(const cv::Mat& image, double saturation_level);

  /// The at most `most_per_ray` steepest edges of each ray, by ray. Those that stand no higher than
  /// the image's noise and texture are left out.
  std::vector<RayEdge> find(const RayFan& fan, std::size_t most_per_ray) const;

 private:
  std::vector<double> profileOf(const RayFan& fan, const Vector2d& direction) const;
  bool nearFullPixel(const Vector2d& place_px) const;

  cv::Mat smooth_;     ///< CV_32FC1
  cv::Mat near_full_;  ///< CV_8UC1, not 0 near a full pixel
  double least_slope_ = 0.0;
};

// Narrow beside the blur of a defocused lens, wide beside a pixel.
constexpr double kSmoothing_px = 1.5;
// Half of a defocused edge and the smoothing: so far a clipped pixel moves it.
constexpr int kFullReach_px = 7;
// Most of an image has no edge: an edge is steeper than so many times its usual slope.
constexpr double kSlopesOverUsual = 4.0;

/// Slopes of a profile taken at every pixel; 0 at its ends.
std::vector<double> slopesOf(const std::vector<double>& profile) {
  std::vector<double> slopes(profile.size(), 0.0);
  for (std::size_t i = 1; i + 1 < profile.size(); ++i) {
    slopes[i] = std::abs(0.5 * (profile[i + 1] - profile[i - 1]));
  }
  return slopes;
}

/// Where between its neighbours the parabola through three slopes is highest, from the middle one.
double topOf(double before, double middle, double after) {
  const double bend = before - 2.0 * middle + after;
  return bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
}

/// Median slope of the image, from a grid of its pixels.
double usualSlope(const cv::Mat& smooth) {
  constexpr int kStep = 5;
  std::vector<float> slopes;
  for (int v = 0; v < smooth.rows; v += kStep) {
    const float* row = smooth.ptr<float>(v);
    for (int u = 1; u + 1 < smooth.cols; u += kStep) {
      slopes.push_back(0.5F * std::abs(row[u + 1] - row[u - 1]));
    }
  }
  if (slopes.empty()) return 0.0;
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  return static_cast<double>(*middle);
}

RayEdgeFinder::RayEdgeFinder(const cv::Mat& image, double saturation_level) {
  image.convertTo(smooth_, CV_32F);
  cv::GaussianBlur(smooth_, smooth_, cv::Size(), kSmoothing_px);
  const int side_px = 2 * kFullReach_px + 1;
  cv::dilate(image >= saturation_level, near_full_, cv::Mat::ones(side_px, side_px, CV_8U));
  constexpr double kRounding = 0.01;  // [levels/px] of a perfectly even image
  least_slope_ = std::max(kRounding, kSlopesOverUsual * usualSlope(smooth_));
}

/// Levels at every pixel along the ray from the fan's begin, as long as it lies in the image.
std::vector<double> RayEdgeFinder::profileOf(const RayFan& fan, const Vector2d& direction) const {
  std::vector<double> profile;
  for (double distance_px = fan.begin_px; distance_px <= fan.end_px; distance_px += 1.0) {
    const Vector2d place = fan.centre_px + distance_px * direction;
    const double u = std::floor(place.x());
    const double v = std::floor(place.y());
    if (!(u >= 0.0 && v >= 0.0 && u < smooth_.cols - 1.0 && v < smooth_.rows - 1.0)) break;
    const float* above = smooth_.ptr<float>(static_cast<int>(v)) + static_cast<int>(u);
    const float* below = smooth_.ptr<float>(static_cast<int>(v) + 1) + static_cast<int>(u);
    const double right = place.x() - u;
    const double down = place.y() - v;
    const auto between = [&](const float* row) {
      return static_cast<double>(row[0]) * (1.0 - right) + static_cast<double>(row[1]) * right;
    };
    profile.push_back(between(above) * (1.0 - down) + between(below) * down);
  }
  return profile;
}

bool RayEdgeFinder::nearFullPixel(const Vector2d& place_px) const {
  const int u = std::clamp(static_cast<int>(std::lround(place_px.x())), 0, near_full_.cols - 1);
  const int v = std::clamp(static_cast<int>(std::lround(place_px.y())), 0, near_full_.rows - 1);
  return near_full_.at<std::uint8_t>(v, u) != 0;
}

std::vector<RayEdge> RayEdgeFinder::find(const RayFan& fan, std::size_t most_per_ray) const {
  std::vector<RayEdge> edges;
  for (int ray = 0; ray < fan.rays; ++ray) {
    const double angle = 2.0 * kPi * ray / fan.rays;
    const Vector2d direction(std::cos(angle), std::sin(angle));
    const std::vector<double> slopes = slopesOf(profileOf(fan, direction));
    std::vector<RayEdge> of_ray;
    for (std::size_t i = 1; i + 1 < slopes.size(); ++i) {
      const bool top = slopes[i] >= slopes[i - 1] && slopes[i] > slopes[i + 1];
      if (!top || slopes[i] < least_slope_) continue;
      const double distance_px =
          fan.begin_px + static_cast<double>(i) + topOf(slopes[i - 1], slopes[i], slopes[i + 1]);
      const Vector2d place = fan.centre_px + distance_px * direction;
      if (!nearFullPixel(place)) of_ray.push_back({ray, place, slopes[i]});
    }
    std::sort(of_ray.begin(), of_ray.end(),
              [](const RayEdge& left, const RayEdge& right) { return left.slope > right.slope; });
    of_ray.resize(std::min(of_ray.size(), most_per_ray));
    edges.insert(edges.end(), of_ray.begin(), of_ray.end());
  }
  return edges;
}

// One ray in four pixels of a usual rim: neighbours share little of their noise.
constexpr int kRays = 360;
constexpr double kLeastVisiblePart = 1.0 / 3.0;

std::vector<RayEdge> candidatesFor(const RayEdgeFinder& finder, const RimSearch& search) {
  constexpr std::size_t kMostPerRay = 6;  // the rim is among the steepest of a ray
  const double begin_px = std::max(0.0, search.radius_px.low - search.max_centre_error_px);
  return finder.find(
      {search.centre_px, kRays, begin_px, search.radius_px.high + search.max_centre_error_px},
      kMostPerRay);
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
std::optional<Circle> likeliestCircle(const std::vector<RayEdge>& edges, const RimSearch& search) {
  // When half of the rays show the rim, as one edge of six, a thousandth of the triples is right.
  constexpr int kTriples = 20000;
  constexpr unsigned kSeed = 1;
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
std::optional<MirrorRim> refine(const RayEdgeFinder& finder, const Circle& first) {
  constexpr double kReaches_px[] = {8.0, 5.0, 5.0};  // either side of the circle
  Circle circle = first;
  std::optional<MirrorRim> rim;
  for (double reach_px : kReaches_px) {
    const RayFan fan{circle.centre_px, kRays, std::max(0.0, circle.radius_px - reach_px),
                     circle.radius_px + reach_px};
    std::vector<Vector2d> places;
    for (const RayEdge& edge : finder.find(fan, 1)) places.push_back(edge.place_px);
    const std::optional<CircleFit> fit = fitCircle(places, circle);
    if (!fit) return std::nullopt;
    circle = fit->circle;
    rim = MirrorRim{circle, fit->covariance_px2, 0.0, fit->scatter_px, {}};
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (fit->belongs[i]) rim->edge_px.push_back(places[i]);
    }
  }
  rim->visible_part = static_cast<double>(rim->edge_px.size()) / kRays;
  return rim;
}

void require(const cv::Mat& image, const RimSearch& search) {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) {
    throw std::invalid_argument("the rim is looked for in grey images of 8 or 16 bits only");
  }
  if (image.empty()) throw std::invalid_argument("there is no rim in an empty image");
  const bool possible = search.centre_px.allFinite() && search.max_centre_error_px >= 0.0 &&
                        search.radius_px.low > 0.0 &&
                        search.radius_px.high >= search.radius_px.low &&
                        std::isfinite(search.radius_px.high + search.max_centre_error_px);
  if (!possible) throw std::invalid_argument("no circle lies in the search for the mirror's rim");
}

}  // namespace

RimSearch rimSearchAround(const DetectorConfig& config) {
  // Lens and mirror are known to some percent, the centre to a part of the rim's radius.
  constexpr double kRadiusError = 0.25;
  constexpr double kCentreError = 0.25;
  const double radius_px = rimRadiusPx(config.mirror);
  return {{config.view.centre_u_px, config.view.centre_v_px},
          kCentreError * radius_px,
          {(1.0 - kRadiusError) * radius_px, (1.0 + kRadiusError) * radius_px},
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

double MirrorRim::stddev(int parameter) const {
  return std::sqrt(covariance_px2(parameter, parameter));
}

std::optional<MirrorRim> findMirrorRim(const cv::Mat& image, const RimSearch& search) {
  require(image, search);
  const RayEdgeFinder finder(image, search.saturation_level);
  const std::optional<Circle> first = likeliestCircle(candidatesFor(finder, search), search);
  if (!first) return std::nullopt;
  const std::optional<MirrorRim> rim = refine(finder, *first);
  const bool seen = rim && rim->visible_part >= kLeastVisiblePart && allowed(rim->circle, search);
  return seen ? rim : std::nullopt;
}

}  // namespace bearing_calibration::core
