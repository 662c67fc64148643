#include "bearing_calibration/output/quality.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/filter/motion_model.h"
#include "bearing_calibration/solve/metric_scale.h"

namespace bearing_calibration::core {
namespace {

/// Share of the prior's variance that data leave which say as much as it does.
constexpr double kAsMuchAsBefore = 0.5;

constexpr int kSize = kMountSize + kErrorCount;
using Covariance = Eigen::Matrix<double, kSize, kSize>;

constexpr double kAhead_m = 3.0;
/// Two so correlated have less than half their own deviation once the other is known:
/// sqrt(1 - r^2).
constexpr double kHighCorrelation = 0.9;

BlockStatus statusOf(bool is_looked_for, double remaining_share) {
  if (!is_looked_for) return BlockStatus::kOff;
  return remaining_share <= kAsMuchAsBefore ? BlockStatus::kEstimated : BlockStatus::kHeldAtPrior;
}

/// By the variance that is left, over that of the prior, in the block's worst known direction. A
/// number that was known beforehand leaves none.
BlockStatus statusOf(const ErrorBlockInfo& block, const ErrorPriors& priors,
                     const ErrorEstimate& estimate) {
  Eigen::VectorXd stddev = priors.stddev.segment(block.begin, block.size);
  // what was known is worth less; the separation is known by that alone
  if (block.name == WheelScales::kName) stddev *= std::sqrt(1.0 + doubtOfLengths(estimate, priors));
  const Eigen::VectorXd precision = (stddev.array() > 0.0).select(stddev.cwiseInverse(), 0.0);
  const Eigen::MatrixXd whitened =
      precision.asDiagonal() *
      estimate.covariance.block(block.begin, block.begin, block.size, block.size) *
      precision.asDiagonal();
  return statusOf(stddev.maxCoeff() > 0.0, eigenOf(whitened).values.maxCoeff());
}

void addNote(const std::string& note, BlockReport* report) {
  report->note += (report->note.empty() ? "" : "; ") + note;
}

/// How far a tilt that is not estimated may shift the sensor: the light's height times the tilt.
void noteTilt(const ErrorPriors& priors, const ErrorEstimate& estimate, double tilt_stddev_rad,
              BlockReport* report) {
  if (report->status == BlockStatus::kEstimated) return;
  const bool is_held = report->status == BlockStatus::kHeldAtPrior;
  double height_m = std::abs(priors.light_height_m);
  if (is_held) {
    const ErrorVector variances = estimate.covariance.diagonal();
    height_m = (estimate.mean.cwiseAbs2() + variances)
                   .segment<kMostLights>(heightAt(0))
                   .cwiseSqrt()
                   .maxCoeff();
  }
  const double rho_stddev_m =
      height_m * (is_held ? priors.stddev(placeOf<SensorTilt>()) : tilt_stddev_rad);
  if (!(rho_stddev_m > 0.0)) return;
  addNote(formatted("rho is uncertain by %.1f mm, the light's height times the possible tilt%s",
                    kMillimetresPerMetre * rho_stddev_m,
                    is_held ? "" : ", which x_stddev and y_stddev leave out"),
          report);
}

/// What near lights may show of a misaligned mirror shifts the sensor.
void noteNearness(const ErrorPriors& priors, BlockReport* report) {
  if (!(priors.nearness_stddev_m > 0.0)) return;
  addNote(formatted("x and y are uncertain by %.1f mm that no bearing determines: find_mirror with "
                    "the lens' principal point removes most of it",
                    kMillimetresPerMetre * priors.nearness_stddev_m),
          report);
}

/// Of a logarithm with a prior.
BlockReport reportFactor(const char* name, const Quantity& number, double prior_stddev,
                         const NoiseFactor& factor, const char* when_held) {
  const double share =
      factor.log_stddev > 0.0 ? std::pow(factor.log_stddev / prior_stddev, 2) : 1.0;
  const BlockStatus status = statusOf(prior_stddev > 0.0, share);
  return {name,
          status,
          {{number, factor.value, factor.value * factor.log_stddev}},
          status == BlockStatus::kHeldAtPrior ? when_held : ""};
}

/// The axis of the largest deviation of a place: unit vector times that.
Eigen::Vector2d worstAxis(const Eigen::Matrix2d& covariance) {
  const SymmetricEigen axes = eigenOf(covariance);
  return std::sqrt(std::max(0.0, axes.values(1))) * axes.vectors.col(1);
}

/// Mount and errors, with the wheel separation taken as it is where the wheels' scales are looked
/// for, too: all lengths stand on it, and no motion tells it.
Covariance withoutMetricScale(const StateEstimate& estimate) {
  const int size = estimate.layout.lastingSize();
  Covariance covariance = Covariance::Zero();
  covariance.topLeftCorner(size, size) = estimate.covariance.topLeftCorner(size, size);
  constexpr int kSeparation = kMountSize + placeOf<WheelSeparation>();
  constexpr int kScale = kMountSize + placeOf<WheelScales>();
  const double variance = covariance(kSeparation, kSeparation);
  if (variance <= 0.0 || covariance(kScale, kScale) <= 0.0) return covariance;
  const Eigen::Matrix<double, kSize, 1> with_it = covariance.col(kSeparation);
  covariance -= with_it * with_it.transpose() / variance;
  covariance.row(kSeparation).setZero();
  covariance.col(kSeparation).setZero();
  return covariance;
}

std::optional<MountQuality::Pair> mostCorrelated(const Covariance& covariance) {
  MountQuality::Pair most;
  for (int i = 0; i < kMountSize; ++i) {
    for (int j = i + 1; j < kSize; ++j) {
      const double variances = covariance(i, i) * covariance(j, j);
      const double correlation = variances > 0.0 ? covariance(i, j) / std::sqrt(variances) : 0.0;
      if (std::abs(correlation) > std::abs(most.correlation)) most = {i, j, correlation};
    }
  }
  if (std::abs(most.correlation) <= kHighCorrelation) return std::nullopt;
  return most;
}

/// Of an error at this place in a pair.
const ErrorBlockInfo& blockOf(int place) {
  const std::vector<ErrorBlockInfo>& blocks = errorBlocks();
  return *std::find_if(blocks.begin(), blocks.end(), [place](const ErrorBlockInfo& block) {
    return place < kMountSize + block.begin + block.size;
  });
}

std::string nameOf(int place) {
  static const char* const kMountNames[] = {"x", "y", "yaw"};
  if (place < kMountSize) return kMountNames[place];
  std::string name = errorQuantities()[static_cast<std::size_t>(place - kMountSize)].name;
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string howToPart(const MountQuality::Pair& pair) {
  switch (motionThatParts(pair)) {
    case PartingMotion::kTurns:
      return "turn on the spot, a full turn to each side, to separate them";
    case PartingMotion::kNearer:
      return "drive to half the light's distance and turn there on the spot, once to each side, to "
             "separate them";
    case PartingMotion::kDistances:
      return "turn on the spot at three distances from the light, near and far, to separate them";
    case PartingMotion::kNone:
      break;
  }
  return "no motion separates them: " + blockOf(pair.second).when_held;
}

std::string inWords(const RivalMount& rival) {
  const std::string search = formatted(
      "of %d fits from yaws all around and %d with a slip elsewhere", rival.minima, rival.slips);
  if (!std::isfinite(rival.gap)) return "no other mount was found: none " + search;
  const Eigen::Vector3d& mount = rival.mount;
  constexpr double kOnAnyRobot_m = 100.0;  // beyond it the numbers mean nothing
  const std::string place = mount.head<2>().norm() > kOnAnyRobot_m
                                ? formatted("beyond %.0f m", kOnAnyRobot_m)
                                : formatted("%.3f m, %.3f m", mount.x(), mount.y());
  return formatted(
      "the next best mount, (%s, %.1f deg), is behind by %.1f of "
      "log-likelihood (open below %.0f): the best other one %s",
      place.c_str(), degreesFromRadians(mount.z()), rival.gap, kOpenGap, search.c_str());
}

}  // namespace

const char* nameOf(BlockStatus status) {
  static const char* const kNames[] = {"off", "held at its prior", "estimated"};
  return kNames[static_cast<int>(status)];
}

std::vector<BlockReport> reportBlocks(const ErrorPriors& priors, const ErrorEstimate& estimate,
                                      double tilt_stddev_rad) {
  std::vector<BlockReport> reports;
  for (const ErrorBlockInfo& block : errorBlocks()) {
    BlockReport report{block.name, statusOf(block, priors, estimate), {}, ""};
    for (int i = block.begin; i < block.begin + block.size; ++i) {
      const bool is_of_no_light = i > heightAt(0) && estimate.covariance(i, i) == 0.0;
      if (is_of_no_light) break;
      report.numbers.push_back({errorQuantities()[static_cast<std::size_t>(i)], estimate.mean(i),
                                std::sqrt(estimate.covariance(i, i))});
    }
    if (report.status == BlockStatus::kHeldAtPrior) report.note = block.when_held;
    if (block.name == MirrorHarmonic::kName) noteNearness(priors, &report);
    if (block.name == SensorTilt::kName) noteTilt(priors, estimate, tilt_stddev_rad, &report);
    reports.push_back(report);
  }
  return reports;
}

std::vector<BlockReport> reportNoise(const NoisePriors& priors, const NoiseLevels& noise,
                                     const CorrelationTime& correlation) {
  const NoiseFactor light_size{noise.light_size.stddev_m, noise.light_size.log_stddev};
  return {reportFactor("bearing_noise", {"bearing_noise_factor", "1"}, priors.bearing_stddev,
                       noise.bearing, "the bearings' noise is as stated: more images determine it"),
          reportFactor("wheel_noise", {"wheel_noise_factor", "1"}, priors.wheel_stddev, noise.wheel,
                       "the wheels' noise is as stated: a longer drive determines it"),
          reportFactor("light_size", {"light_size", "m"}, priors.lightSizeStddev(), light_size,
                       "the light is taken for a point: bearings nearer to it determine its size"),
          {"bearing_correlation",
           correlation.value_s > 0.0 ? BlockStatus::kEstimated : BlockStatus::kOff,
           {{{"bearing_correlation_time", "s"}, correlation.value_s, correlation.stddev_s}},
           ""}};
}

std::vector<BlockReport> reportErrors(const CalibrationResult& result, double tilt_stddev_rad) {
  std::vector<BlockReport> reports =
      reportBlocks(result.error_priors, result.robot_errors, tilt_stddev_rad);
  for (const BlockReport& report :
       reportNoise(result.noise_priors, result.noise, result.correlation_time)) {
    reports.push_back(report);
  }
  return reports;
}

MountQuality qualityOf(const StateEstimate& estimate) {
  const MountEstimate mount = estimate.mount();
  Eigen::Matrix<double, 2, 3> J_light_mount;
  J_light_mount << Eigen::Matrix2d::Identity(),
      perpendicular(Eigen::Vector2d(kAhead_m, 0.0) - mount.mean.head<2>());
  Eigen::Vector2d worst = worstAxis(mount.covariance.topLeftCorner<2, 2>());
  if (worst.x() < 0.0 || (worst.x() == 0.0 && worst.y() < 0.0)) worst = -worst;
  return {worstAxis(J_light_mount * mount.covariance * J_light_mount.transpose()).norm(),
          std::atan2(worst.y(), worst.x()), worst.norm(),
          mostCorrelated(withoutMetricScale(estimate))};
}

PartingMotion motionThatParts(const MountQuality::Pair& pair) {
  if (pair.second < kMountSize) return PartingMotion::kNearer;
  const std::string& block = blockOf(pair.second).name;
  if (block == SensorTilt::kName) return PartingMotion::kNone;
  if (block == MirrorHarmonic::kName) return PartingMotion::kDistances;
  const bool is_of_wheels = block == WheelScales::kName || block == WheelSeparation::kName;
  const bool is_of_position = pair.first < 2;
  return is_of_wheels && is_of_position ? PartingMotion::kTurns : PartingMotion::kNearer;
}

std::vector<std::string> qualityInWords(const CalibrationResult& result) {
  if (!result.estimate || !mayBeTrusted(result.state)) return {};
  const MountQuality quality = qualityOf(*result.estimate);
  std::vector<std::string> words = {
      formatted("a light %.0f m ahead is placed within %.1f mm (68 %%) along any axis", kAhead_m,
                kMillimetresPerMetre * quality.light_ahead_stddev_m),
      formatted("the position is known least along %.0f deg (0: forward, 90: left), to %.1f mm "
                "(68 %%)",
                degreesFromRadians(quality.worst_direction_rad),
                kMillimetresPerMetre * quality.worst_stddev_m)};
  if (quality.most_correlated) {
    const MountQuality::Pair& pair = *quality.most_correlated;
    words.push_back(formatted("%s and %s correlate most (%+.2f): %s", nameOf(pair.first).c_str(),
                              nameOf(pair.second).c_str(), pair.correlation,
                              howToPart(pair).c_str()));
  }
  words.push_back(inWords(result.rival));
  return words;
}

}  // namespace bearing_calibration::core
