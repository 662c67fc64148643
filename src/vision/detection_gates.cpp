#include "bearing_calibration/vision/detection_gates.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

// Thresholding a dim light leaves the core of its spot, a bright one gains a pixel all round.
constexpr double kLeastPartOfArea = 0.4;
constexpr double kLargestPartOfArea = 2.5;
// A few pixels cannot look round: the fill's tolerance grows by this over the number of pixels in a
// disc as wide as the spot is narrow.
constexpr double kSmallSpotFill = 0.5;
// What is farther from an ellipse is several things.
constexpr double kLeastFill = 0.85;
constexpr double kMostFill = 1.05;
// An ellipse has an axis to compare when one deviation exceeds the other by so much.
constexpr double kElongated = 1.25;

// What a spot's measures take from the logarithm of its odds to be a light: chosen on 2000 random
// scenes, half of them without light (doc/detection.md).
constexpr double kPerfect = 16.4;  // of a spot without any doubt
constexpr double kOfMisfit = 2.6;  // for each squared standard deviation of the size
// For each e-fold that the light is larger than a point.
constexpr double kOfTangentialExtent = 11.0;
constexpr double kOfRadialExtent = 28.0;
constexpr double kOfKurtosis = 70.0;
constexpr double kOfOutline = 11.0;    // for each pixel that it lies elsewhere than the moments say
constexpr double kOfSaturation = 6.2;  // of all pixels: nothing is left to tell it by
constexpr double kOpened = 1.4;
constexpr double kUsualSpots = 20.0;  // of an image; where there are more, more are like a light
constexpr double kKurtosisOfDisc = 4.0 / 3.0;
// Normal errors.
constexpr double kFillStddev = 0.035;
constexpr double kAxisStddev_rad = radiansFromDegrees(2.0);

/// Angle between the ellipse's axis and the mirror's radius or tangent, whichever is nearer [rad].
double axisError(const LightEllipse& ellipse) {
  const double difference = ellipse.radial_variance_px2 - ellipse.tangential_variance_px2;
  return 0.5 * std::atan2(2.0 * ellipse.mixed_variance_px2, std::abs(difference));
}

bool hasAxis(const SpotSize& expected) {
  return std::abs(expected.log_point(0) - expected.log_point(1)) > std::log(kElongated);
}

double halfSquare(double sigmas) { return 0.5 * sigmas * sigmas; }

Eigen::Vector2d logStddevs(const LightEllipse& ellipse) {
  return {0.5 * std::log(std::max(kPixelVariance, ellipse.tangential_variance_px2)),
          0.5 * std::log(std::max(kPixelVariance, ellipse.radial_variance_px2))};
}

/// A light's image is as large as a point's (but for the optics' uncertainty), or larger by the
/// light's own extent, of which large ones are rare (an exponential distribution).
struct SizeFit {
  Eigen::Vector2d extent = Eigen::Vector2d::Zero();   ///< logarithms: tangential, radial
  Eigen::Vector2d misfit2 = Eigen::Vector2d::Zero();  ///< squared deviation, shared by the axes
};
SizeFit fitSize(const LightEllipse& ellipse, const SpotSize& expected) {
  constexpr double kRate = 3.0;  // of the extents' distribution
  constexpr int kRounds = 6;     // of coordinate descent
  const Eigen::Matrix2d information = expected.log_covariance.inverse();
  const Eigen::Vector2d off = logStddevs(ellipse) - expected.log_point;
  const Eigen::Vector2d most(std::log(expected.tangential_stddev_px.high) - expected.log_point(0),
                             std::log(expected.radial_stddev_px.high) - expected.log_point(1));
  SizeFit fit;
  for (int round = 0; round < kRounds; ++round) {
    for (int i : {0, 1}) {
      const int j = 1 - i;
      const double best =
          off(i) + (information(i, j) * (off(j) - fit.extent(j)) - kRate) / information(i, i);
      fit.extent(i) = std::clamp(best, 0.0, std::max(0.0, most(i)));
    }
  }
  const Eigen::Vector2d rest = off - fit.extent;
  fit.misfit2 = rest.cwiseProduct(information * rest);
  return fit;
}

/// By how much the outline at the threshold is off that of the ellipse with the same moments: not
/// at all where the light is evenly filled [px].
double outlineError_px(const LightEllipse& ellipse) {
  const double log_square_px2 = logStddevs(ellipse).sum();
  const double log_area = std::log(4.0 * kPi) + log_square_px2;
  return std::exp(0.5 * log_square_px2) * std::abs(std::log(ellipse.pixels) - log_area);
}

}  // namespace

double fillTolerance(const BlobShape& shape) {
  const double mean = 0.5 * shape.covariance_px2.trace();
  const double difference = shape.covariance_px2(0, 0) - mean;
  const double smallest = mean - std::hypot(difference, shape.covariance_px2(0, 1));
  return kSmallSpotFill / (4.0 * kPi * smallest);
}

const char* describe(Rejection rejection) {
  static constexpr std::array<const char*, kRejections> kWords{
      "accepted",
      "too few pixels",
      "too many pixels",
      "not an ellipse",
      "cut by the mask",
      "nothing over the background",
      "above the horizon",
      "wrong size along the azimuth",
      "wrong size along the radius",
      "axis off the radius",
      "not evenly filled",
      "unlike a light",
      "too many spots",
  };
  return kWords.at(static_cast<std::size_t>(rejection));
}

Rejection rejectionOf(const Blob& blob, const BlobShape& shape, const GateConfig& gates,
                      const Range& area_px) {
  const double pixels = static_cast<double>(blob.pixels);
  double least = gates.min_pixels;
  double most = gates.max_pixels;
  if (gates.mirror) {
    least = std::max(least, kLeastPartOfArea * area_px.low);
    most = std::min(most, kLargestPartOfArea * area_px.high);
  }
  if (pixels < least) return Rejection::kTooFewPixels;
  if (pixels > most) return Rejection::kTooManyPixels;
  if (blob.cut) return Rejection::kMaskEdge;
  const double small = fillTolerance(shape);
  const bool elliptical = shape.fill >= kLeastFill - small && shape.fill <= kMostFill + small;
  return elliptical ? Rejection::kNone : Rejection::kFill;
}

Doubts doubtsAbout(const LightEllipse& ellipse, const SpotSize& expected, const Search& search,
                   const GateConfig& gates) {
  const double fill = (ellipse.fill - 1.0) / (kFillStddev + ellipse.fill_tolerance);
  Doubts doubts;
  doubts[0] = {Rejection::kFill, halfSquare(fill)};
  if (!gates.mirror) return doubts;
  const SizeFit size = fitSize(ellipse, expected);
  doubts[1] = {Rejection::kTangentialSize,
               kOfMisfit * size.misfit2(0) + kOfTangentialExtent * size.extent(0)};
  doubts[2] = {Rejection::kRadialSize,
               kOfMisfit * size.misfit2(1) + kOfRadialExtent * size.extent(1)};
  if (hasAxis(expected)) {
    doubts[3] = {Rejection::kAxis, halfSquare(axisError(ellipse) / kAxisStddev_rad)};
  }
  if (!std::isnan(ellipse.kurtosis)) {
    doubts[4] = {Rejection::kKurtosis,
                 kOfKurtosis * std::max(0.0, ellipse.kurtosis - expected.max_kurtosis)};
  }
  // Where the light is not expected to be evenly filled, its outline says little.
  const double evenly_filled = (2.0 - expected.max_kurtosis) / (2.0 - kKurtosisOfDisc);
  doubts[5] = {Rejection::kKurtosis, kOfOutline * evenly_filled * outlineError_px(ellipse)};
  doubts[6] = {Rejection::kUnlikely, kOfSaturation * ellipse.saturated_fraction};
  doubts[7] = {Rejection::kUnlikely, search.opened ? kOpened : 0.0};
  return doubts;
}

double probabilityOf(const Doubts& doubts, const Search& search) {
  double log_odds = kPerfect - search.log_part_searched - std::log(search.thresholds) -
                    std::log(std::max(1.0, search.spots / kUsualSpots));
  for (const Doubt& doubt : doubts) log_odds -= doubt.log_odds;
  return 1.0 / (1.0 + std::exp(-log_odds));
}

Rejection largestOf(const Doubts& doubts) {
  constexpr double kDecisive = 6.0;  // less is one of many reasons
  const auto largest = std::max_element(
      doubts.begin(), doubts.end(),
      [](const Doubt& left, const Doubt& right) { return left.log_odds < right.log_odds; });
  return largest->log_odds > kDecisive ? largest->reason : Rejection::kUnlikely;
}

}  // namespace bearing_calibration::core
