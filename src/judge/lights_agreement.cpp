#include "bearing_calibration/judge/lights_agreement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/solve/rival_mount.h"

namespace bearing_calibration::core {
namespace {

/// Of calling one of several sound lights a contradicting one.
constexpr double kFalseAlarm = 1e-4;
/// The covariance of a difference is twice the sum of both at most, however they hang together.
constexpr double kShared = 2.0;

/// Chi-square of two independent mounts that all pairs of `lights` stay below, and what they share
/// allowed for.
double limitFor(std::size_t lights) {
  const double pairs = std::max(1.0, 0.5 * static_cast<double>(lights * (lights - 1)));
  return kShared * chiSquareQuantile(1.0 - kFalseAlarm / pairs, kMountSize);
}

/// What speaks against one light.
struct Objection {
  int lights = 0;  ///< that it contradicts
  double chi_square = 0.0;

  bool operator<(const Objection& other) const {
    return lights != other.lights ? lights < other.lights : chi_square < other.chi_square;
  }
};

Objection objectionTo(std::size_t light, const std::vector<std::size_t>& others,
                      const std::vector<MountEstimate>& mounts, double limit) {
  Objection objection;
  for (std::size_t other : others) {
    if (other == light) continue;
    const double chi_square = disagreement(mounts[light], mounts[other]);
    objection.lights += chi_square > limit ? 1 : 0;
    objection.chi_square += chi_square;
  }
  return objection;
}

}  // namespace

LightsAgreement compareLights(const std::vector<MountEstimate>& mounts) {
  LightsAgreement agreement;
  const double limit = limitFor(mounts.size());
  std::vector<std::size_t>& agreeing = agreement.agreeing;
  for (std::size_t i = 0; i < mounts.size(); ++i) agreeing.push_back(i);
  const auto objection = [&](std::size_t light) {
    return objectionTo(light, agreeing, mounts, limit);
  };
  while (agreeing.size() > 1) {
    const auto worst =
        std::max_element(agreeing.begin(), agreeing.end(),
                         [&](std::size_t a, std::size_t b) { return objection(a) < objection(b); });
    if (objection(*worst).lights == 0) break;
    agreement.contradicting.push_back(*worst);
    agreeing.erase(worst);
  }
  return agreement;
}

double contradiction(const MountEstimate& own, const MountEstimate& joint) {
  // Directions in which the joint estimate says hardly more than the light's own do not count.
  constexpr double kLeastGain = 0.05;
  const Eigen::LLT<Eigen::Matrix3d> root(own.covariance);
  const Eigen::Vector3d standardised = root.matrixL().solve(mountDifference(own.mean, joint.mean));
  const Eigen::Matrix3d half = root.matrixL().solve(joint.covariance);
  const Eigen::Matrix3d ratio = root.matrixL().solve(half.transpose());
  const SymmetricEigen axes = eigenOf(0.5 * (ratio + ratio.transpose()));
  double chi_square = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double gain = 1.0 - axes.values(i);
    if (gain < kLeastGain) continue;
    chi_square += std::pow(axes.vectors.col(i).dot(standardised), 2) / gain;
  }
  return chi_square;
}

Eigen::Matrix3d leastSpread(const std::vector<Eigen::Matrix3d>& spreads,
                            const Eigen::Matrix3d& covariance) {
  Eigen::Matrix3d least = Eigen::Matrix3d::Zero();
  double least_size = std::numeric_limits<double>::infinity();
  const Eigen::LLT<Eigen::Matrix3d> root(covariance);
  for (const Eigen::Matrix3d& spread : spreads) {
    const Eigen::Matrix3d half = root.matrixL().solve(spread);
    const Eigen::Matrix3d ratio = root.matrixL().solve(half.transpose());
    const SymmetricEigen axes = eigenOf(0.5 * (ratio + ratio.transpose()));
    const Eigen::Vector3d positive = axes.values.cwiseMax(0.0);
    if (positive.sum() >= least_size) continue;
    least_size = positive.sum();
    const Eigen::Matrix3d directions = root.matrixL() * axes.vectors;
    least = directions * positive.asDiagonal() * directions.transpose();
  }
  return least;
}

double largestContradiction(std::size_t lights, double probability) {
  return chiSquareQuantile(1.0 - probability / static_cast<double>(lights), kMountSize);
}

}  // namespace bearing_calibration::core
