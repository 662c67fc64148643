#include "bearing_calibration/vision/detection.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

using Eigen::Vector2d;

// Thresholding a dim light leaves the core of its spot, a bright one gains a pixel all round.
constexpr double kLeastPartOfArea = 0.4;
constexpr double kLargestPartOfArea = 2.5;
// What is farther from an ellipse is several things.
constexpr double kLeastFill = 0.85;
constexpr double kMostFill = 1.05;
// An ellipse has an axis to compare when one deviation exceeds the other by so much.
constexpr double kElongated = 1.25;

// What a spot's measures take from the logarithm of its odds to be a light: chosen on 2000 random
// scenes, half of them without light (detection.md).
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

double halfSquare(double sigmas) { return 0.5 * sigmas * sigmas; }

Vector2d logStddevs(const LightEllipse& ellipse) {
  return 0.5 * ellipse.variances_px2().array().log();
}

/// A light's image is as large as a point's (but for the optics' uncertainty), or larger by the
/// light's own extent, of which large ones are rare (an exponential distribution).
Vector2d sizeDoubts(const LightEllipse& ellipse, const SpotSize& expected) {
  constexpr double kRate = 3.0;  // of the extents' distribution
  constexpr int kRounds = 6;     // of coordinate descent
  const Eigen::Matrix2d information = expected.log_covariance.inverse();
  const Vector2d off = logStddevs(ellipse) - expected.log_point;
  const Vector2d most = expected.most_stddev_px.array().log().matrix() - expected.log_point;
  Vector2d extent = Vector2d::Zero();  // logarithms
  for (int round = 0; round < kRounds; ++round) {
    for (int i : {0, 1}) {
      const int j = 1 - i;
      const double best =
          off(i) + (information(i, j) * (off(j) - extent(j)) - kRate) / information(i, i);
      extent(i) = std::clamp(best, 0.0, std::max(0.0, most(i)));
    }
  }
  const Vector2d rest = off - extent;
  const Vector2d misfit2 = rest.cwiseProduct(information * rest);  // shared by the axes
  return kOfMisfit * misfit2 + Vector2d(kOfTangentialExtent, kOfRadialExtent).cwiseProduct(extent);
}

/// Angle between the ellipse's axis and the mirror's radius or tangent, whichever is nearer [rad];
/// 0 where a light's has none.
double axisError(const LightEllipse& ellipse, const SpotSize& expected) {
  const double log_ratio = expected.log_point(0) - expected.log_point(1);
  if (std::abs(log_ratio) <= std::log(kElongated)) return 0.0;
  const Eigen::Matrix2d& moments = ellipse.moments_px2;
  return 0.5 * std::atan2(2.0 * moments(0, 1), std::abs(moments(1, 1) - moments(0, 0)));
}

/// By how much the outline at the threshold is off that of the ellipse with the same moments: not
/// at all where the light is evenly filled [px].
double outlineError_px(const LightEllipse& ellipse) {
  const double log_square_px2 = logStddevs(ellipse).sum();
  const double log_area = std::log(4.0 * kPi) + log_square_px2;
  return std::exp(0.5 * log_square_px2) * std::abs(std::log(ellipse.pixels) - log_area);
}

}  // namespace

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
      "beyond what the lens shows",
      "too many spots",
  };
  return kWords.at(static_cast<std::size_t>(rejection));
}

Rejection rejectionOf(const LightEllipse& thresholded, const GateConfig& gates,
                      const ExpectedSpot* expected) {
  double least = gates.min_pixels;
  double most = gates.max_pixels;
  if (expected != nullptr) {
    least = std::max(least, kLeastPartOfArea * expected->area_px().low);
    most = std::min(most, kLargestPartOfArea * expected->area_px().high);
  }
  if (thresholded.pixels < least) return Rejection::kTooFewPixels;
  if (thresholded.pixels > most) return Rejection::kTooManyPixels;
  if (thresholded.cut) return Rejection::kMaskEdge;
  const bool elliptical = thresholded.fill >= kLeastFill - thresholded.fill_tolerance &&
                          thresholded.fill <= kMostFill + thresholded.fill_tolerance;
  return elliptical ? Rejection::kNone : Rejection::kFill;
}

LightProbability probabilityOf(const LightEllipse& ellipse, const ExpectedSpot* expected,
                               const Search& search) {
  double log_odds = kPerfect - std::log(search.part_searched) - std::log(search.thresholds) -
                    std::log(std::max(1.0, search.spots / kUsualSpots));
  double largest = 6.0;  // less is one of many reasons
  LightProbability probability;
  const auto doubt = [&](Rejection reason, double by) {
    log_odds -= by;
    if (!(by > largest)) return;
    largest = by;
    probability.doubt = reason;
  };
  doubt(Rejection::kFill,
        halfSquare((ellipse.fill - 1.0) / (kFillStddev + ellipse.fill_tolerance)));
  if (expected != nullptr) {
    const SpotSize& size = expected->at(ellipse.centre_px);
    const Vector2d by_size = sizeDoubts(ellipse, size);
    doubt(Rejection::kTangentialSize, by_size(0));
    doubt(Rejection::kRadialSize, by_size(1));
    doubt(Rejection::kAxis, halfSquare(axisError(ellipse, size) / kAxisStddev_rad));
    if (!std::isnan(ellipse.kurtosis)) {
      doubt(Rejection::kKurtosis,
            kOfKurtosis * std::max(0.0, ellipse.kurtosis - size.max_kurtosis));
    }
    // Where the light is not expected to be evenly filled, its outline says little.
    const double evenly_filled = (2.0 - size.max_kurtosis) / (2.0 - kKurtosisOfDisc);
    doubt(Rejection::kKurtosis, kOfOutline * evenly_filled * outlineError_px(ellipse));
    doubt(Rejection::kUnlikely, kOfSaturation * ellipse.saturated_fraction);
    doubt(Rejection::kUnlikely, search.opened ? kOpened : 0.0);
  }
  probability.value = 1.0 / (1.0 + std::exp(-log_odds));
  return probability;
}

}  // namespace bearing_calibration::core
