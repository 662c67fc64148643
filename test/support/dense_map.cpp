#include "support/dense_map.h"

#include <Eigen/Dense>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core::testing {
namespace {

/// Unknowns: state at the first observation, then three standardised noises of each later motion.
Vector5 stateAfter(const std::vector<Observation>& observations,
                   const std::vector<Eigen::Matrix3d>& roots, const Eigen::VectorXd& unknowns,
                   std::size_t last, Eigen::VectorXd* residuals) {
  Vector5 state = unknowns.head<5>();
  for (std::size_t i = 0; i <= last; ++i) {
    if (i > 0) {
      const auto at = static_cast<Eigen::Index>(5 + 3 * (i - 1));
      const Eigen::Vector3d noise = roots[i] * unknowns.segment<3>(at);
      const Pose2& measured = observations[i].motion.start_from_end;
      const Pose2 motion{measured.position_m - noise.head<2>(), measured.yaw_rad - noise(2)};
      state.head<2>() = motion.inverse() * Eigen::Vector2d(state.head<2>());
    }
    if (residuals == nullptr) continue;
    const Eigen::Vector2d ray = state.head<2>() - state.segment<2>(2);
    (*residuals)(static_cast<Eigen::Index>(i)) =
        wrapAngle(observations[i].azimuth_rad - std::atan2(ray.y(), ray.x()) + state(4)) /
        std::sqrt(observations[i].azimuth_variance_rad2);
  }
  return state;
}

}  // namespace

CartesianEstimate maximisePosterior(const std::vector<Observation>& observations,
                                    const Vector5& start) {
  constexpr double kStep = 1e-6;
  constexpr int kIterations = 15;
  const auto n = static_cast<Eigen::Index>(observations.size());
  const Eigen::Index size = 5 + 3 * (n - 1);
  std::vector<Eigen::Matrix3d> roots;
  for (const Observation& observation : observations) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(observation.motion.covariance);
    roots.push_back(solver.eigenvectors() *
                    solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal());
  }
  const auto residualsOf = [&](const Eigen::VectorXd& unknowns) {
    Eigen::VectorXd residuals(n);
    stateAfter(observations, roots, unknowns, observations.size() - 1, &residuals);
    return residuals;
  };
  Eigen::VectorXd unknowns = Eigen::VectorXd::Zero(size);
  unknowns.head<5>() = start;
  Eigen::MatrixXd information;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::VectorXd residuals = residualsOf(unknowns);
    Eigen::MatrixXd J(n, size);
    for (Eigen::Index k = 0; k < size; ++k) {
      Eigen::VectorXd moved = unknowns;
      moved(k) += kStep;
      J.col(k) = (residualsOf(moved) - residuals) / kStep;
    }
    information = J.transpose() * J;
    Eigen::VectorXd gradient = -J.transpose() * residuals;
    for (Eigen::Index k = 5; k < size; ++k) {
      information(k, k) += 1.0;
      gradient(k) -= unknowns(k);
    }
    unknowns += information.ldlt().solve(gradient);
  }
  CartesianEstimate estimate;
  const auto lastOf = [&](const Eigen::VectorXd& x) {
    return stateAfter(observations, roots, x, observations.size() - 1, nullptr);
  };
  estimate.mean = lastOf(unknowns);
  estimate.mean(4) = wrapAngle(estimate.mean(4));
  Eigen::MatrixXd J_last(5, size);
  for (Eigen::Index k = 0; k < size; ++k) {
    Eigen::VectorXd moved = unknowns;
    moved(k) += kStep;
    J_last.col(k) = (lastOf(moved) - lastOf(unknowns)) / kStep;
  }
  estimate.covariance = J_last * information.ldlt().solve(J_last.transpose());
  return estimate;
}

}  // namespace bearing_calibration::core::testing
