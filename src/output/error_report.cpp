#include "bearing_calibration/output/error_report.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "bearing_calibration/common/formatted.h"

namespace bearing_calibration::core {
namespace {

/// Share of the prior's variance that data leave which say as much as it does.
constexpr double kAsMuchAsBefore = 0.5;

/// Variance that is left, over that of the prior, in the block's worst known direction. A number
/// that was known beforehand leaves none.
double remainingShare(const ErrorBlockInfo& block, const ErrorPriors& priors,
                      const ErrorEstimate& estimate) {
  const Eigen::VectorXd stddev = priors.stddev.segment(block.begin, block.size);
  const Eigen::MatrixXd covariance =
      estimate.covariance.block(block.begin, block.begin, block.size, block.size);
  const Eigen::VectorXd precision =
      (stddev.array() > 0.0).select(stddev.cwiseInverse(), Eigen::VectorXd::Zero(block.size));
  const Eigen::MatrixXd whitened = precision.asDiagonal() * covariance * precision.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(whitened, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

BlockStatus statusOf(const ErrorBlockInfo& block, const ErrorPriors& priors,
                     const ErrorEstimate& estimate) {
  if (!(priors.stddev.segment(block.begin, block.size).maxCoeff() > 0.0)) return BlockStatus::kOff;
  return remainingShare(block, priors, estimate) <= kAsMuchAsBefore ? BlockStatus::kEstimated
                                                                    : BlockStatus::kHeldAtPrior;
}

/// How far a tilt that is not estimated may shift the sensor: the light's height times the tilt.
void noteTilt(const ErrorPriors& priors, const ErrorEstimate& estimate, double tilt_stddev_rad,
              BlockReport& report) {
  if (report.status == BlockStatus::kEstimated) return;
  constexpr int kTilt = placeOf<SensorTilt>();
  constexpr int kHeight = kTilt + SensorTilt::kHeight;
  const bool is_held = report.status == BlockStatus::kHeldAtPrior;
  const double height_m =
      is_held ? std::hypot(estimate.mean(kHeight), std::sqrt(estimate.covariance(kHeight, kHeight)))
              : std::abs(priors.light_height_m);
  const double tilt_rad = is_held ? priors.stddev(kTilt) : tilt_stddev_rad;
  const double rho_stddev_m = height_m * tilt_rad;
  if (!(rho_stddev_m > 0.0)) return;
  constexpr double kMillimetres = 1e3;
  if (!report.note.empty()) report.note += "; ";
  report.note += "rho is uncertain by " + formatted("%.1f", kMillimetres * rho_stddev_m) +
                 " mm, the light's height times the tilt that may be" +
                 (is_held ? "" : ", which x_stddev and y_stddev leave out");
}

/// What near lights may show of a misaligned mirror shifts the sensor.
void noteNearness(const ErrorPriors& priors, BlockReport& report) {
  if (!(priors.nearness_stddev_m > 0.0)) return;
  constexpr double kMillimetres = 1e3;
  if (!report.note.empty()) report.note += "; ";
  report.note += "x and y are uncertain by " +
                 formatted("%.1f", kMillimetres * priors.nearness_stddev_m) +
                 " mm that no bearing tells: find_mirror with the lens' principal point takes most "
                 "of it away";
}

/// Of a logarithm with a prior.
BlockStatus statusOf(double prior_stddev, const NoiseFactor& factor) {
  if (!(prior_stddev > 0.0)) return BlockStatus::kOff;
  const bool is_found =
      factor.log_stddev > 0.0 && std::pow(factor.log_stddev / prior_stddev, 2) <= kAsMuchAsBefore;
  return is_found ? BlockStatus::kEstimated : BlockStatus::kHeldAtPrior;
}

BlockReport reportFactor(const char* name, const char* number, double prior_stddev,
                         const NoiseFactor& factor, const char* when_held) {
  BlockReport report{name,
                     statusOf(prior_stddev, factor),
                     {{{number, "1"}, factor.value, factor.value * factor.log_stddev}},
                     ""};
  if (report.status == BlockStatus::kHeldAtPrior) report.note = when_held;
  return report;
}

}  // namespace

const char* nameOf(BlockStatus status) {
  switch (status) {
    case BlockStatus::kOff:
      return "off";
    case BlockStatus::kHeldAtPrior:
      return "held at its prior";
    case BlockStatus::kEstimated:
      return "estimated";
  }
  return "unknown";
}

std::vector<BlockReport> reportBlocks(const ErrorPriors& priors, const ErrorEstimate& estimate,
                                      double tilt_stddev_rad) {
  std::vector<BlockReport> reports;
  for (const ErrorBlockInfo& block : errorBlocks()) {
    BlockReport report;
    report.name = block.name;
    report.status = statusOf(block, priors, estimate);
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      report.numbers.push_back({errorQuantities()[static_cast<std::size_t>(i)], estimate.mean(i),
                                std::sqrt(estimate.covariance(i, i))});
    }
    if (report.status == BlockStatus::kHeldAtPrior) report.note = block.when_held;
    if (block.name == MirrorHarmonic::kName) noteNearness(priors, report);
    if (block.name == SensorTilt::kName) noteTilt(priors, estimate, tilt_stddev_rad, report);
    reports.push_back(report);
  }
  return reports;
}

std::vector<BlockReport> reportNoise(const NoisePriors& priors, const NoiseLevels& noise,
                                     const CorrelationTime& correlation) {
  BlockReport memory{
      "bearing_correlation",
      BlockStatus::kOff,
      {{{"bearing_correlation_time", "s"}, correlation.value_s, correlation.stddev_s}},
      ""};
  if (correlation.value_s > 0.0) memory.status = BlockStatus::kEstimated;
  return {reportFactor("bearing_noise", "bearing_noise_factor", priors.bearing_stddev,
                       noise.bearing, "the bearings' noise is as stated: more images tell it"),
          reportFactor("wheel_noise", "wheel_noise_factor", priors.wheel_stddev, noise.wheel,
                       "the wheels' noise is as stated: a longer way tells it"),
          memory};
}

}  // namespace bearing_calibration::core
