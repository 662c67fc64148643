#include "bearing_calibration/vision/ray_edges.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

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

}  // namespace

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

}  // namespace bearing_calibration::core
