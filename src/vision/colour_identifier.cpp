#include "bearing_calibration/vision/colour_identifier.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "bearing_calibration/common/parameters.h"

namespace bearing_calibration::core {
namespace {

// The spot ends at two standard deviations; an interpolated mosaic smears it by a pixel, which the
// surroundings' ring leaves out.
constexpr double kSpotReach = 2.2;
constexpr double kColourRingBegin = 3.2;
constexpr double kColourRingEnd = 4.5;
constexpr int kLeastPixels = 5;
constexpr std::size_t kLeastRingPixels = 12;
// Of all channels together, on average over the spot's pixels that are not full: less is noise.
constexpr double kLeastLight_levels = 10.0;

ColourParts partsOf(const Eigen::Vector3d& colour) { return colour / colour.sum(); }

/// Of one channel; changes the pixels' order.
double median(int channel, std::vector<cv::Vec3b>* pixels) {
  const auto middle = pixels->begin() + static_cast<std::ptrdiff_t>(pixels->size() / 2);
  std::nth_element(pixels->begin(), middle, pixels->end(),
                   [channel](const cv::Vec3b& left, const cv::Vec3b& right) {
                     return left[channel] < right[channel];
                   });
  return (*middle)[channel];
}

std::optional<ColourParts> colourOf(const cv::Mat& bgr, const LightEllipse& spot,
                                    const DetectorConfig& detector) {
  constexpr double kFull = std::numeric_limits<std::uint8_t>::max();
  const double saturation_level = std::min(detector.sensor.saturation_level, kFull);
  const Eigen::Matrix2d axes = mirrorAxes(spot.centre_px, detector.view.centre_px());
  const Eigen::Vector2d variances_px2 = spot.variances_px2();
  const Eigen::Matrix2d information =
      axes * variances_px2.cwiseInverse().asDiagonal() * axes.transpose();
  const double largest_px = std::sqrt(variances_px2.maxCoeff());
  const int reach_px = static_cast<int>(std::ceil(kColourRingEnd * largest_px));
  const cv::Rect box =
      cv::Rect(cvRound(spot.centre_px.x()) - reach_px, cvRound(spot.centre_px.y()) - reach_px,
               2 * reach_px + 1, 2 * reach_px + 1) &
      cv::Rect(cv::Point(0, 0), bgr.size());
  Eigen::Vector3d levels = Eigen::Vector3d::Zero();  // blue, green, red
  int pixels = 0;
  std::vector<cv::Vec3b> ring;
  for (int v = box.y; v < box.y + box.height; ++v) {
    const cv::Vec3b* row = bgr.ptr<cv::Vec3b>(v);
    for (int u = box.x; u < box.x + box.width; ++u) {
      const Eigen::Vector2d offset = Eigen::Vector2d(u, v) - spot.centre_px;
      const double distance = std::sqrt(offset.dot(information * offset));
      const Eigen::Vector3d level(row[u][0], row[u][1], row[u][2]);
      if (distance >= kColourRingBegin && distance <= kColourRingEnd) {
        ring.push_back(row[u]);
      } else if (distance <= kSpotReach && level.maxCoeff() < saturation_level) {
        levels += level;
        ++pixels;
      }
    }
  }
  if (pixels < kLeastPixels || ring.size() < kLeastRingPixels) return std::nullopt;
  const Eigen::Vector3d background(median(0, &ring), median(1, &ring), median(2, &ring));
  const Eigen::Vector3d light = (levels - pixels * background).cwiseMax(0.0);
  if (light.sum() < pixels * kLeastLight_levels) return std::nullopt;
  return partsOf({light[2], light[1], light[0]});
}

}  // namespace

void ColourConfig::declare(Parameters& params) {
  constexpr double kBrightest = 1e6;  // in any unit
  params.read("colour/use", use);
  params.list("colour/lights", 4, lights, [&params](const auto& row) {
    constexpr std::int32_t kLargest = std::numeric_limits<std::int32_t>::max();
    const bool is_id = row[0] >= 0.0 && row[0] <= kLargest && row[0] == std::floor(row[0]);
    params.that(is_id, formatted("colour/lights: a light_id must be a whole number from 0 to %d, "
                                 "but one is %g",
                                 kLargest, row[0]));
    return ColouredLight{is_id ? static_cast<std::int32_t>(row[0]) : 0, {row[1], row[2], row[3]}};
  });
  params.that(!use || !lights.empty(), "colour/lights must name a light for colour/use");
  params.number("colour/tolerance", tolerance, 0.0, 1.0);
  for (const ColouredLight& light : lights) {
    params.that(light.light_id >= 0, "colour/lights: a light_id must not be negative, but one is " +
                                         std::to_string(light.light_id));
    const bool shines = light.colour.allFinite() && light.colour.minCoeff() >= 0.0 &&
                        light.colour.maxCoeff() <= kBrightest && light.colour.sum() > 0.0;
    params.that(shines, "colour/lights: red, green and blue of light " +
                            std::to_string(light.light_id) +
                            " must not be negative, nor above 1e6, nor all of them 0");
  }
}

std::vector<std::optional<ColourParts>> coloursOf(const cv::Mat& bgr,
                                                  const std::vector<Detection>& lights,
                                                  const DetectorConfig& detector) {
  std::vector<std::optional<ColourParts>> colours;
  for (const Detection& light : lights) colours.push_back(colourOf(bgr, light.ellipse, detector));
  return colours;
}

void identifyByColour(const ColourConfig& config,
                      const std::vector<std::optional<ColourParts>>& colours, BearingSet* set) {
  if (colours.size() != set->candidates.size()) {
    throw std::invalid_argument("a colour is needed for each candidate");
  }
  for (std::size_t i = 0; i < colours.size(); ++i) {
    Bearing& candidate = set->candidates[i];
    candidate.light_id = kUnknownLight;
    double nearest = config.tolerance;
    for (const ColouredLight& light : config.lights) {
      if (!colours[i]) continue;
      const double distance = (*colours[i] - partsOf(light.colour)).norm();
      if (distance > nearest) continue;
      nearest = distance;
      candidate.light_id = light.light_id;
    }
    if (candidate.light_id == kUnknownLight) {
      candidate.probability = candidate.track_probability = 0.0;
    }
  }
}

}  // namespace bearing_calibration::core
