#include "bearing_calibration/vision/annulus_mask.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

bool hiddenByPost(const MaskConfig& config, double azimuth_rad) {
  return std::any_of(config.posts.begin(), config.posts.end(), [&](const MirrorPost& post) {
    return std::abs(wrapAngle(azimuth_rad - post.azimuth_rad)) <= post.half_width_rad;
  });
}

bool mayShowALight(const MaskConfig& config, const MirrorView& view, int u, int v) {
  if (v < config.first_row || v > config.last_row) return false;
  const MirrorPixel pixel = mirrorPixelFromImage(view, u, v);
  return pixel.image_radius_px >= config.inner_radius_px &&
         pixel.image_radius_px <= config.outer_radius_px &&
         !hiddenByPost(config, pixel.azimuth_rad);
}

/// Points (u, up) about the mirror's centre with u * normal_u + up * normal_up >= 0.
struct HalfPlane {
  explicit HalfPlane(double normal_angle_rad)
      : normal_u(std::cos(normal_angle_rad)),
        normal_up(std::sin(normal_angle_rad)),
        border_u_over_up(-normal_up / normal_u) {}

  double normal_u;
  double normal_up;
  double border_u_over_up;  ///< of the points on the border
};

/// Narrows the strip, `up` pixels above the centre, to the half plane.
void clipTo(const HalfPlane& half_plane, double centre_u, double up, PixelStrip* strip) {
  constexpr double kParallel = 1e-12;  // a border along the row cuts all of it or nothing
  if (std::abs(half_plane.normal_u) < kParallel) {
    if (up * half_plane.normal_up < 0.0) strip->end = strip->begin;
    return;
  }
  const double border =
      std::clamp(centre_u + up * half_plane.border_u_over_up, strip->begin - 1.0, strip->end + 1.0);
  if (half_plane.normal_u > 0.0) {
    strip->begin = std::max(strip->begin, static_cast<int>(std::ceil(border)));
  } else {
    strip->end = std::min(strip->end, static_cast<int>(std::floor(border)) + 1);
  }
}

/// How far above and below the centre a sector of the unit circle reaches.
struct Heights {
  double lowest;
  double highest;
};
Heights heightsOf(double angle_rad, double half_width_rad) {
  const auto reaches = [&](double direction_rad) {
    return std::abs(wrapAngle(direction_rad - angle_rad)) <= half_width_rad;
  };
  const double first = std::sin(angle_rad - half_width_rad);
  const double second = std::sin(angle_rad + half_width_rad);
  return {reaches(-0.5 * kPi) ? -1.0 : std::min({0.0, first, second}),
          reaches(0.5 * kPi) ? 1.0 : std::max({0.0, first, second})};
}

}  // namespace

AnnulusMask::AnnulusMask(const MaskConfig& config, const MirrorView& view,
                         const ImageSensor& sensor)
    : view_(view),
      width_px_(sensor.width_px),
      height_px_(sensor.height_px),
      outer_radius_px_(config.outer_radius_px) {
  // What lies beside the image is not in the mask, either.
  cv::Mat inside = cv::Mat::zeros(height_px_ + 2, width_px_ + 2, CV_8UC1);
  for (int v = 0; v < height_px_; ++v) {
    std::uint8_t* row = inside.ptr(v + 1) + 1;
    for (int u = 0; u < width_px_; ++u) {
      row[u] = mayShowALight(config, view, u, v) ? 1 : 0;
      if (row[u] == 0) continue;
      const bool goes_on = row[u - 1] != 0;
      if (!goes_on) strips_.push_back({v, u, u});
      strips_.back().end = u + 1;
    }
  }
  cv::Mat distances;
  cv::distanceTransform(inside, distances, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  // Less a half, the conversion rounds down.
  distances(cv::Rect(1, 1, width_px_, height_px_)).convertTo(clearance_, CV_8UC1, 1.0, -0.49);
}

/// Writes what `narrow` leaves of the strips in the rows from the first to the last.
template <typename Narrow>
void AnnulusMask::clip(double first_row, double last_row, Narrow narrow,
                       std::vector<PixelStrip>* strips) const {
  strips->clear();
  auto it = std::lower_bound(strips_.begin(), strips_.end(), first_row,
                             [](const PixelStrip& strip, double row) { return strip.row < row; });
  for (; it != strips_.end() && it->row <= last_row; ++it) {
    PixelStrip strip = *it;
    narrow(&strip);
    if (strip.begin < strip.end) strips->push_back(strip);
  }
}

void AnnulusMask::clipToSector(const AzimuthSector& sector, std::vector<PixelStrip>* strips) const {
  if (!(sector.half_width_rad > 0.0 && sector.half_width_rad < 0.5 * kPi)) {
    throw std::invalid_argument("a sector's half width must lie between 0 and 90 deg, but is " +
                                std::to_string(sector.half_width_rad) + " rad");
  }
  // A wedge is the common part of two half planes through the centre; the inward normal of a
  // border is the border turned by a quarter towards the wedge.
  const double screen_angle = view_.handedness * sector.centre_rad;
  const HalfPlane first(screen_angle - sector.half_width_rad + 0.5 * kPi);
  const HalfPlane second(screen_angle + sector.half_width_rad - 0.5 * kPi);
  const Heights heights = heightsOf(screen_angle, sector.half_width_rad);
  constexpr double kMargin_px = 1.0;  // for the rounding to rows
  const double first_row = view_.centre_v_px - heights.highest * outer_radius_px_ - kMargin_px;
  const double last_row = view_.centre_v_px - heights.lowest * outer_radius_px_ + kMargin_px;
  const auto narrow = [&](PixelStrip* strip) {
    const double up = view_.centre_v_px - strip->row;
    clipTo(first, view_.centre_u_px, up, strip);
    clipTo(second, view_.centre_u_px, up, strip);
  };
  clip(first_row, last_row, narrow, strips);
}

void AnnulusMask::clipToBox(const cv::Rect& box, std::vector<PixelStrip>* strips) const {
  const auto narrow = [&](PixelStrip* strip) {
    strip->begin = std::max(strip->begin, box.x);
    strip->end = std::min(strip->end, box.br().x);
  };
  clip(box.y, box.br().y - 1, narrow, strips);
}

int AnnulusMask::clearancePx(double u_px, double v_px) const {
  const double u = u_px + 0.5;
  const double v = v_px + 0.5;
  if (!(u >= 0.0 && u < width_px_ && v >= 0.0 && v < height_px_)) return 0;
  return clearance_.at<std::uint8_t>(static_cast<int>(v), static_cast<int>(u));
}

}  // namespace bearing_calibration::core
