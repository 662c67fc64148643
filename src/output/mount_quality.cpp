#include "bearing_calibration/output/mount_quality.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/output/saving_rule.h"

namespace bearing_calibration::core {
namespace {

constexpr int kSize = kMountSize + kErrorCount;
using Covariance = Eigen::Matrix<double, kSize, kSize>;

constexpr double kAhead_m = 3.0;
/// Two so correlated have less than half their own deviation once the other is known: sqrt(1 -
/// r^2).
constexpr double kHighCorrelation = 0.9;

/// The axis of the largest deviation of a place: unit vector times that.
Eigen::Vector2d worstAxis(const Eigen::Matrix2d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(covariance);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(1))) * solver.eigenvectors().col(1);
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

const ErrorBlockInfo& blockOf(int error) {
  const std::vector<ErrorBlockInfo>& blocks = errorBlocks();
  return *std::find_if(blocks.begin(), blocks.end(), [error](const ErrorBlockInfo& block) {
    return error < block.begin + block.size;
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
      return "turn on the spot, a full turn to each side, to part them";
    case PartingMotion::kNearer:
      return "drive to half the light's distance and turn there on the spot, once to each side, to "
             "part them";
    case PartingMotion::kDistances:
      return "turn on the spot at three distances from the light, near and far, to part them";
    case PartingMotion::kNone:
      break;
  }
  return "no motion parts them: " + blockOf(pair.second - kMountSize).when_held;
}

std::string inWords(const RivalMount& rival) {
  const std::string search = formatted(
      "of %d fits from yaws all around and %d with a slip elsewhere", rival.minima, rival.slips);
  if (!std::isfinite(rival.gap)) return "no other mount came up: none " + search;
  const Eigen::Vector3d& mount = rival.mount;
  return formatted(
      "the next best mount, (%.3f m, %.3f m, %.1f deg), is behind by %.1f of "
      "log-likelihood (open below %.0f): the best other one %s",
      mount.x(), mount.y(), degreesFromRadians(mount.z()), rival.gap, kOpenGap, search.c_str());
}

}  // namespace

MountQuality qualityOf(const StateEstimate& estimate) {
  const MountEstimate mount = estimate.mount();
  Eigen::Matrix<double, 2, 3> J_light_mount;
  J_light_mount << Eigen::Matrix2d::Identity(),
      perpendicular(Eigen::Vector2d(kAhead_m, 0.0) - mount.mean.head<2>());
  MountQuality quality;
  quality.light_ahead_stddev_m =
      worstAxis(J_light_mount * mount.covariance * J_light_mount.transpose()).norm();
  Eigen::Vector2d worst = worstAxis(mount.covariance.topLeftCorner<2, 2>());
  if (worst.x() < 0.0 || (worst.x() == 0.0 && worst.y() < 0.0)) worst = -worst;
  quality.worst_direction_rad = std::atan2(worst.y(), worst.x());
  quality.worst_stddev_m = worst.norm();
  quality.most_correlated = mostCorrelated(withoutMetricScale(estimate));
  return quality;
}

PartingMotion motionThatParts(const MountQuality::Pair& pair) {
  if (pair.second < kMountSize) return PartingMotion::kNearer;
  const std::string& block = blockOf(pair.second - kMountSize).name;
  if (block == SensorTilt::kName) return PartingMotion::kNone;
  if (block == MirrorHarmonic::kName) return PartingMotion::kDistances;
  const bool is_of_wheels = block == WheelScales::kName || block == WheelSeparation::kName;
  const bool is_of_position = pair.first < 2;
  return is_of_wheels && is_of_position ? PartingMotion::kTurns : PartingMotion::kNearer;
}

std::vector<std::string> qualityInWords(const CalibrationResult& result) {
  if (!result.estimate || !mayBeTrusted(result.state)) return {};
  constexpr double kMillimetres = 1e3;
  const MountQuality quality = qualityOf(*result.estimate);
  std::vector<std::string> words;
  words.push_back(formatted("a light %.0f m ahead is placed within %.1f mm (68 %%) along any axis",
                            kAhead_m, kMillimetres * quality.light_ahead_stddev_m));
  words.push_back(formatted(
      "the position is known least along %.0f deg (0: forward, 90: left), to "
      "%.1f mm (68 %%)",
      degreesFromRadians(quality.worst_direction_rad), kMillimetres * quality.worst_stddev_m));
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
