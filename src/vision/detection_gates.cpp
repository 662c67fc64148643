#include "bearing_calibration/vision/detection_gates.h"

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
// An ellipse has an axis to compare when one deviation exceeds the other by so much.
constexpr double kElongated = 1.25;
constexpr double kGateSigmas = 3.0;

/// Departure of `value` from the range in units of `tolerance` times its nearer end.
double relativeDeparture(double value, const Range& range) {
  if (value < range.low) return value / range.low - 1.0;
  if (value > range.high) return value / range.high - 1.0;
  return 0.0;
}

bool hasAxis(const SpotSize& expected) {
  return expected.radial_stddev_px.low > kElongated * expected.tangential_stddev_px.high ||
         expected.tangential_stddev_px.low > kElongated * expected.radial_stddev_px.high;
}

/// Angle between the ellipse's axis and the mirror's radius or tangent, whichever is nearer [rad].
double axisError(const LightEllipse& ellipse) {
  const double difference = ellipse.radial_variance_px2 - ellipse.tangential_variance_px2;
  return 0.5 * std::atan2(2.0 * ellipse.mixed_variance_px2, std::abs(difference));
}

double fillPartOfGate(const LightEllipse& ellipse, const GateConfig& gates) {
  const double small = ellipse.fill_tolerance;
  const double departure = ellipse.fill - 1.0;
  return departure < 0.0 ? -departure / (1.0 - gates.min_fill + small)
                         : departure / (gates.max_fill - 1.0 + small);
}

/// 0 where the kurtosis says nothing, or lies below what is expected: holes are the fill's
/// matter.
double kurtosisPartOfGate(const LightEllipse& ellipse, const SpotSize& expected,
                          const GateConfig& gates) {
  const double departure = ellipse.kurtosis - expected.max_kurtosis;
  return departure > 0.0 ? departure / gates.kurtosis_tolerance : 0.0;
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
  const bool elliptical =
      shape.fill >= gates.min_fill - small && shape.fill <= gates.max_fill + small;
  return elliptical ? Rejection::kNone : Rejection::kFill;
}

PartsOfGates partsOfGates(const LightEllipse& ellipse, const SpotSize& expected,
                          const GateConfig& gates) {
  PartsOfGates parts;
  parts.fill = fillPartOfGate(ellipse, gates);
  if (!gates.mirror) return parts;
  const double tangential = std::sqrt(std::max(0.0, ellipse.tangential_variance_px2));
  const double radial = std::sqrt(std::max(0.0, ellipse.radial_variance_px2));
  parts.tangential =
      relativeDeparture(tangential, expected.tangential_stddev_px) / gates.size_tolerance;
  parts.radial = relativeDeparture(radial, expected.radial_stddev_px) / gates.size_tolerance;
  if (hasAxis(expected)) parts.axis = axisError(ellipse) / gates.max_axis_error_rad;
  parts.kurtosis = kurtosisPartOfGate(ellipse, expected, gates);
  return parts;
}

Rejection rejectionOf(const PartsOfGates& parts) {
  const auto exceeds = [](double part) { return std::abs(part) > 1.0; };
  if (exceeds(parts.tangential)) return Rejection::kTangentialSize;
  if (exceeds(parts.radial)) return Rejection::kRadialSize;
  if (parts.axis && exceeds(*parts.axis)) return Rejection::kAxis;
  return exceeds(parts.kurtosis) ? Rejection::kKurtosis : Rejection::kNone;
}

double probabilityOf(const PartsOfGates& parts, const GateConfig& gates) {
  constexpr double kLightOverClutter = 2.0 * kGateSigmas / 2.5066282746310002;  // sqrt(2 pi)
  double ratio = 1.0;  // of the densities in the middle of the gates
  double squares = 0.0;
  const auto add = [&](double part_of_gate) {
    ratio *= kLightOverClutter;
    squares += std::pow(kGateSigmas * part_of_gate, 2);
  };
  add(parts.fill);
  if (gates.mirror) {
    for (double part : {parts.tangential, parts.radial, parts.kurtosis}) add(part);
  }
  if (parts.axis) add(*parts.axis);
  ratio *= std::exp(-0.5 * squares);
  return ratio / (1.0 + ratio);
}

}  // namespace bearing_calibration::core
