#include "bearing_calibration/vision/search_region.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

bool mayShowALight(const DetectorConfig& detector, int u, int v) {
  const MaskConfig& config = detector.mask;
  if (v < config.first_row || v > config.last_row) return false;
  if (detector.mirror_kind == MirrorKind::kNone) return true;
  const MirrorPixel pixel = mirrorPixelFromImage(detector.view, u, v);
  const auto hides = [&](const MirrorPost& post) {
    return std::abs(wrapAngle(pixel.azimuth_rad - post.azimuth_rad)) <= post.half_width_rad;
  };
  return pixel.image_radius_px >= config.inner_radius_px &&
         pixel.image_radius_px <= config.outer_radius_px &&
         std::none_of(config.posts.begin(), config.posts.end(), hides);
}

/// The half plane of a normal, its border through the mirror's centre.
struct HalfPlane {
  explicit HalfPlane(double normal_angle_rad)
      : lies_right(std::cos(normal_angle_rad) > 0.0),
        border_right_per_up(-std::tan(normal_angle_rad)) {}

  bool lies_right;
  double border_right_per_up;
};

/// Narrows the strip, `up` pixels above the centre, to the half plane.
void clipTo(const HalfPlane& half_plane, double centre_u, double up, PixelStrip* strip) {
  const double border = std::clamp(centre_u + up * half_plane.border_right_per_up,
                                   strip->begin - 1.0, strip->end + 1.0);
  if (half_plane.lies_right) {
    strip->begin = std::max(strip->begin, static_cast<int>(std::ceil(border)));
  } else {
    strip->end = std::min(strip->end, static_cast<int>(std::floor(border)) + 1);
  }
}

std::vector<Eigen::Vector2d> unitVectorsAllAround() {
  constexpr int kDirections = 16;
  std::vector<Eigen::Vector2d> directions;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2.0 * kPi * i / kDirections;
    directions.emplace_back(std::cos(angle), std::sin(angle));
  }
  return directions;
}

/// Writes what `narrow` leaves of the mask's strips in the rows from the first to the last.
template <typename Narrow>
void clip(const std::vector<PixelStrip>& mask, double first_row, double last_row, Narrow narrow,
          std::vector<PixelStrip>* strips) {
  strips->clear();
  auto it = std::lower_bound(mask.begin(), mask.end(), first_row,
                             [](const PixelStrip& strip, double row) { return strip.row < row; });
  for (; it != mask.end() && it->row <= last_row; ++it) {
    PixelStrip strip = *it;
    narrow(&strip);
    if (strip.begin < strip.end) strips->push_back(strip);
  }
}

}  // namespace

AnnulusMask::AnnulusMask(const DetectorConfig& config)
    : view_(config.view), outer_radius_px_(config.mask.outer_radius_px) {
  const int width = config.sensor.width_px;
  const int height = config.sensor.height_px;
  inside_ = cv::Mat1b::zeros(height, width);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (!mayShowALight(config, u, v)) continue;
      const bool goes_on = u > 0 && inside_(v, u - 1) != 0;
      if (!goes_on) strips_.push_back({v, u, u});
      strips_.back().end = u + 1;
      inside_(v, u) = 1;
    }
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
  const auto narrow = [&](PixelStrip* strip) {
    const double up = view_.centre_v_px - strip->row;
    clipTo(first, view_.centre_u_px, up, strip);
    clipTo(second, view_.centre_u_px, up, strip);
  };
  // Rows: as far as the wedge's direction that is nearest to straight up or down.
  const auto reach_px = [&](double direction_rad) {
    constexpr double kMargin_px = 1.0;  // for the rounding to rows
    const double off_rad = std::abs(wrapAngle(direction_rad - screen_angle));
    const double nearest_rad = std::max(0.0, off_rad - sector.half_width_rad);
    return std::max(0.0, std::cos(nearest_rad)) * outer_radius_px_ + kMargin_px;
  };
  clip(strips_, view_.centre_v_px - reach_px(0.5 * kPi), view_.centre_v_px + reach_px(-0.5 * kPi),
       narrow, strips);
}

void AnnulusMask::clipToBox(const cv::Rect& box, std::vector<PixelStrip>* strips) const {
  const auto narrow = [&](PixelStrip* strip) {
    strip->begin = std::max(strip->begin, box.x);
    strip->end = std::min(strip->end, box.br().x);
  };
  clip(strips_, box.y, box.br().y - 1, narrow, strips);
}

bool AnnulusMask::contains(double u_px, double v_px) const {
  const double u = u_px + 0.5;
  const double v = v_px + 0.5;
  return u >= 0.0 && u < inside_.cols && v >= 0.0 && v < inside_.rows &&
         inside_(static_cast<int>(v), static_cast<int>(u)) != 0;
}

bool AnnulusMask::cuts(const PixelEllipse& ellipse) const {
  static const std::vector<Eigen::Vector2d> directions = unitVectorsAllAround();
  const Eigen::Matrix2d information = ellipse.covariance_px2.inverse();
  for (const Eigen::Vector2d& direction : directions) {
    const double reach = ellipse.size / std::sqrt(direction.dot(information * direction));
    const Eigen::Vector2d outline = ellipse.centre_px + reach * direction;
    if (!contains(outline.x(), outline.y())) return true;
  }
  return false;
}

void SearchConfig::declare(Parameters& params) {
  constexpr double kFastest_pxps = 1e6;
  params.read("prediction/use", use);
  params.number("prediction/sigmas", sigmas, 0.0, plausible::kMostSigmas);
  params.number("prediction/margin", margin_rad, plausible::kLeastAngle_rad, kPi);
  params.number("prediction/max_age", max_age_s, 0.0, plausible::kLongest_s);
  params.number("time/max_turn_rate", max_turn_rate_radps, 0.0, plausible::kFastestTurn_radps);
  params.number("prediction/max_radius_rate", max_radius_rate_pxps, 0.0, kFastest_pxps);
}

std::optional<SeenRadius> seenRadius(const BearingSet& bearings,
                                     const BearingPrediction& prediction) {
  const auto off = [&](const Bearing& candidate) {
    return std::abs(wrapAngle(candidate.azimuth_rad - prediction.azimuth_rad));
  };
  const auto nearest = std::min_element(
      bearings.candidates.begin(), bearings.candidates.end(),
      [&](const Bearing& left, const Bearing& right) { return off(left) < off(right); });
  if (nearest == bearings.candidates.end()) return std::nullopt;
  return SeenRadius{bearings.stamp, nearest->image_radius_px, nearest->image_radius_variance_px2};
}

std::optional<SearchRegion> searchRegion(const SearchConfig& config,
                                         const BearingPrediction& prediction,
                                         const std::optional<SeenRadius>& seen, Stamp stamp) {
  constexpr double kWidest_rad = 0.8;  // wider, the whole mirror is searched as soon
  if (!config.use) return std::nullopt;
  const double age_s = std::abs(secondsFromDuration(stamp - prediction.stamp));
  const double half_width_rad = config.sigmas * std::sqrt(prediction.azimuth_variance_rad2) +
                                config.max_turn_rate_radps * age_s;
  const bool useful = std::isfinite(prediction.azimuth_rad) && age_s <= config.max_age_s &&
                      config.margin_rad + half_width_rad <= kWidest_rad;
  if (!useful) return std::nullopt;
  const double azimuth_rad = wrapAngle(prediction.azimuth_rad);
  SearchRegion region{std::nullopt, {azimuth_rad, config.margin_rad + half_width_rad}};
  if (!seen) return region;
  const double unseen_s = std::abs(secondsFromDuration(stamp - seen->stamp));
  if (unseen_s > config.max_age_s) return region;
  const double half_height_px =
      config.sigmas * std::sqrt(seen->radius_variance_px2) + config.max_radius_rate_pxps * unseen_s;
  region.place = ExpectedPlace{{seen->radius_px, azimuth_rad}, half_width_rad, half_height_px};
  return region;
}

cv::Rect boxAround(const ExpectedPlace& place, const ExpectedSpot& expected,
                   const DetectorConfig& config) {
  constexpr double kRim_px = 2.0;
  constexpr double kDisc = 2.0;  // standard deviations to an evenly filled ellipse's outline
  const double radius_px = place.centre.image_radius_px;
  const Eigen::Vector2d centre = imageFromMirrorPixel(config.view, place.centre);
  const Eigen::Vector2d largest = kDisc * expected.at(centre).pointStddev_px(1.0);
  const double bow = 0.5 * radius_px * place.half_width_rad * place.half_width_rad;  // of an arc
  const double along = place.half_height_px + bow;
  const double across = radius_px * place.half_width_rad;
  const auto half_of = [&](double outward, double sideways) {
    const double r = largest(1) * outward;
    const double t = largest(0) * sideways;
    return along * outward + across * sideways + std::sqrt(r * r + t * t) + kRim_px;
  };
  const double cosine = std::abs(std::cos(place.centre.azimuth_rad));
  const double sine = std::abs(std::sin(place.centre.azimuth_rad));
  const Eigen::Array2d half_sides(half_of(cosine, sine), half_of(sine, cosine));
  const auto corner = [&](const Eigen::Array2d& place_px) {
    const Eigen::Array2d end(config.sensor.width_px, config.sensor.height_px);
    const Eigen::Array2i pixel = place_px.max(0.0).min(end).cast<int>();
    return cv::Point(pixel.x(), pixel.y());
  };
  return {corner(centre.array() - half_sides), corner(centre.array() + half_sides + 1.0)};
}

}  // namespace bearing_calibration::core
