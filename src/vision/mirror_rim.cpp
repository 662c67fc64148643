#include "bearing_calibration/vision/mirror_rim.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/vision/ray_edges.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

// One ray in four pixels of a usual rim: neighbours share little of their noise.
constexpr int kRays = 360;
constexpr double kLeastVisiblePart = 1.0 / 3.0;

struct Candidates {
  std::vector<RayEdge> edges;           ///< by ray
  std::vector<std::size_t> first_edge;  ///< of each ray, and one past the last
};

Candidates candidatesFor(const RayEdgeFinder& finder, const RimSearch& search) {
  constexpr std::size_t kMostPerRay = 6;  // the rim is among the steepest of a ray
  const double begin_px = std::max(0.0, search.radius_px.low - search.max_centre_error_px);
  Candidates candidates;
  candidates.edges = finder.find(
      {search.centre_px, kRays, begin_px, search.radius_px.high + search.max_centre_error_px},
      kMostPerRay);
  std::size_t edge = 0;
  for (int ray = 0; ray <= kRays; ++ray) {
    while (edge < candidates.edges.size() && candidates.edges[edge].ray < ray) ++edge;
    candidates.first_edge.push_back(edge);
  }
  return candidates;
}

/// Rays of which an edge lies on the circle.
int supportOf(const Circle& circle, const Candidates& candidates) {
  constexpr double kNear_px = 2.0;
  int rays = 0;
  for (std::size_t ray = 0; ray < static_cast<std::size_t>(kRays); ++ray) {
    for (std::size_t i = candidates.first_edge[ray]; i < candidates.first_edge[ray + 1]; ++i) {
      const double distance_px = (candidates.edges[i].place_px - circle.centre_px).norm();
      if (std::abs(distance_px - circle.radius_px) > kNear_px) continue;
      ++rays;
      break;
    }
  }
  return rays;
}

bool allowed(const Circle& circle, const RimSearch& search) {
  return (circle.centre_px - search.centre_px).norm() <= search.max_centre_error_px &&
         circle.radius_px >= search.radius_px.low && circle.radius_px <= search.radius_px.high;
}

/// The circle through three edges that has the longest edge.
std::optional<Circle> likeliestCircle(const Candidates& candidates, const RimSearch& search) {
  // When half of the rays show the rim, as one edge of six, a thousandth of the triples is right.
  constexpr int kTriples = 20000;
  constexpr unsigned kSeed = 1;
  if (candidates.edges.empty()) return std::nullopt;
  std::mt19937 random(kSeed);
  std::uniform_int_distribution<std::size_t> pick(0, candidates.edges.size() - 1);
  std::optional<Circle> best;
  double longest_px = 0.0;
  for (int i = 0; i < kTriples; ++i) {
    const auto circle = circleThrough(candidates.edges[pick(random)].place_px,
                                      candidates.edges[pick(random)].place_px,
                                      candidates.edges[pick(random)].place_px);
    if (!circle || !allowed(*circle, search)) continue;
    const double length_px = circle->radius_px * supportOf(*circle, candidates);
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
