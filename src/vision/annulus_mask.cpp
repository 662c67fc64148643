#include "bearing_calibration/vision/annulus_mask.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration {
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

/// Narrows [*begin, *end) to the columns u with slope * (u - centre_u) + offset >= 0.
void clipToHalfPlane(double slope, double offset, double centre_u, int* begin, int* end) {
  constexpr double kParallel = 1e-12;  // a border along the row cuts all of it or nothing
  if (std::abs(slope) < kParallel) {
    if (offset < 0.0) *end = *begin;
    return;
  }
  const double border = std::clamp(centre_u - offset / slope, *begin - 1.0, *end + 1.0);
  if (slope > 0.0) {
    *begin = std::max(*begin, static_cast<int>(std::ceil(border)));
  } else {
    *end = std::min(*end, static_cast<int>(std::floor(border)) + 1);
  }
}

}  // namespace

AnnulusMask::AnnulusMask(const MaskConfig& config, const MirrorView& view,
                         const ImageSensor& sensor)
    : view_(view),
      width_px_(sensor.width_px),
      height_px_(sensor.height_px),
      inside_(static_cast<std::size_t>(sensor.width_px) * sensor.height_px, 0) {
  for (int v = 0; v < height_px_; ++v) {
    std::uint8_t* row = inside_.data() + static_cast<std::size_t>(v) * width_px_;
    for (int u = 0; u < width_px_; ++u) {
      row[u] = mayShowALight(config, view, u, v) ? 1 : 0;
      if (row[u] == 0) continue;
      const bool goes_on = u > 0 && row[u - 1] != 0;
      if (!goes_on) intervals_.push_back({v, u, u});
      intervals_.back().end = u + 1;
    }
  }
}

void AnnulusMask::clip(const AzimuthSector& sector, std::vector<PixelInterval>* intervals) const {
  if (!(sector.half_width_rad > 0.0 && sector.half_width_rad < 0.5 * kPi)) {
    throw std::invalid_argument("a sector's half width must lie between 0 and 90 deg, but is " +
                                std::to_string(sector.half_width_rad) + " rad");
  }
  // A wedge is the common part of two half planes through the centre; the inward normal of a
  // border is the border turned by a quarter towards the wedge.
  const double screen_angle = view_.handedness * sector.centre_rad;
  const double first_normal = screen_angle - sector.half_width_rad + 0.5 * kPi;
  const double second_normal = screen_angle + sector.half_width_rad - 0.5 * kPi;
  intervals->clear();
  for (PixelInterval interval : intervals_) {
    const double up = view_.centre_v_px - interval.row;
    for (double normal : {first_normal, second_normal}) {
      clipToHalfPlane(std::cos(normal), up * std::sin(normal), view_.centre_u_px, &interval.begin,
                      &interval.end);
    }
    if (interval.begin < interval.end) intervals->push_back(interval);
  }
}

bool AnnulusMask::contains(double u_px, double v_px) const {
  const double u = std::round(u_px);
  const double v = std::round(v_px);
  if (!(u >= 0.0 && u < width_px_ && v >= 0.0 && v < height_px_)) return false;
  return inside_[static_cast<std::size_t>(v) * width_px_ + static_cast<std::size_t>(u)] != 0;
}

}  // namespace bearing_calibration
