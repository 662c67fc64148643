#include "bearing_calibration/filter/lasting_estimate.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "bearing_calibration/common/angle.h"

namespace bearing_calibration::core {
namespace {

constexpr int kYaw = 2;

/// Places of what an earlier calibration and a state both know: the mount, and errors that both
/// look for.
struct Shared {
  std::vector<int> of_earlier;
  std::vector<int> of_state;
};

Shared sharedPlaces(const LastingEstimate& earlier, const ErrorPriors& priors,
                    const LastingPlaces& places) {
  Shared shared;
  for (int i = 0; i < LastingEstimate::kMountSize; ++i) {
    shared.of_earlier.push_back(i);
    shared.of_state.push_back(places.mount + i);
  }
  for (int error = 0; error < places.error_count; ++error) {
    const int place = LastingEstimate::kMountSize + error;
    if (!earlier.isKnown(place) || !(priors.stddev(error) > 0.0)) continue;
    shared.of_earlier.push_back(place);
    shared.of_state.push_back(places.errors + error);
  }
  return shared;
}

/// The matrix that takes these places out of a vector.
Eigen::MatrixXd selection(const std::vector<int>& places, Eigen::Index size) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(places.size()), size);
  for (std::size_t i = 0; i < places.size(); ++i) {
    matrix(static_cast<Eigen::Index>(i), places[i]) = 1.0;
  }
  return matrix;
}

/// What measurements say of some numbers: gradient and negative curvature of their logarithmic
/// likelihood, the latter by its root.
struct Knowledge {
  Eigen::VectorXd pull;
  Eigen::MatrixXd root;
};

/// Without directions in which the information is not positive: by rounding, or because an earlier
/// calibration was told less beforehand.
/// @param unit  in which each of the numbers is measured, so that they can be compared
Knowledge positivePart(const Eigen::MatrixXd& information, const Eigen::VectorXd& pull,
                       const Eigen::VectorXd& unit) {
  constexpr double kRounding = 1e-9;
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(0.5 * (scaled + scaled.transpose()));
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(0.0);
  Eigen::VectorXd along = solver.eigenvectors().transpose() * unit.cwiseProduct(pull);
  along = (values.array() > kRounding).select(along, 0.0);
  const Eigen::MatrixXd directions = unit.cwiseInverse().asDiagonal() * solver.eigenvectors();
  return {directions * along, directions * values.cwiseSqrt().asDiagonal()};
}

}  // namespace

LastingEstimate LastingEstimate::of(const MountEstimate& mount) {
  LastingEstimate lasting;
  lasting.mean.head<kMountSize>() = mount.mean;
  lasting.covariance.topLeftCorner<kMountSize, kMountSize>() = mount.covariance;
  return lasting;
}

LastingEstimate LastingEstimate::of(const RobotEstimate& robot) {
  LastingEstimate lasting = of(mountFromCartesian(robot.cartesian));
  lasting.mean.tail<kErrorCount>() = robot.errors.mean;
  lasting.covariance.bottomRightCorner<kErrorCount, kErrorCount>() = robot.errors.covariance;
  lasting.covariance.topRightCorner<kMountSize, kErrorCount>() =
      robot.errors.cross_covariance.bottomRows<kMountSize>();
  for (int i = 0; i < kErrorCount; ++i) {
    if (lasts(i)) continue;
    lasting.mean(kMountSize + i) = 0.0;
    lasting.covariance.row(kMountSize + i).setZero();
    lasting.covariance.col(kMountSize + i).setZero();
  }
  lasting.covariance.bottomLeftCorner<kErrorCount, kMountSize>() =
      lasting.covariance.topRightCorner<kMountSize, kErrorCount>().transpose();
  return lasting;
}

MountEstimate LastingEstimate::mount() const {
  return {mean.head<kMountSize>(), covariance.topLeftCorner<kMountSize, kMountSize>()};
}

std::vector<std::string> lastingNames() {
  std::vector<std::string> names = {"x [m]", "y [m]", "yaw [rad]"};
  for (const Quantity& error : errorQuantities()) names.push_back(labelOf(error));
  return names;
}

void addEarlier(const LastingEstimate& earlier, const ErrorPriors& priors,
                const LastingPlaces& places, Eigen::Ref<Eigen::VectorXd> mean,
                Eigen::Ref<Eigen::MatrixXd> covariance) {
  const Shared shared = sharedPlaces(earlier, priors, places);
  const Eigen::MatrixXd E = selection(shared.of_earlier, LastingEstimate::kSize);
  const Eigen::MatrixXd H = selection(shared.of_state, mean.size());
  const Eigen::MatrixXd known = E * earlier.covariance * E.transpose();
  Eigen::VectorXd off = E * earlier.mean - H * mean;
  off(kYaw) = wrapAngle(off(kYaw));
  Eigen::MatrixXd information =
      known.ldlt().solve(Eigen::MatrixXd::Identity(known.rows(), known.cols()));
  Eigen::VectorXd pull = information * off;
  for (int i = LastingEstimate::kMountSize; i < known.rows(); ++i) {
    const auto place = static_cast<std::size_t>(i);
    const int error = shared.of_earlier[place] - LastingEstimate::kMountSize;
    const double beforehand = 1.0 / (priors.stddev(error) * priors.stddev(error));
    information(i, i) -= beforehand;
    pull(i) -= beforehand * (priors.mean(error) - mean(shared.of_state[place]));
  }
  const Knowledge measured = positivePart(information, pull, known.diagonal().cwiseSqrt());
  const Eigen::MatrixXd half = covariance * H.transpose() * measured.root;
  const Eigen::MatrixXd S =
      Eigen::MatrixXd::Identity(half.cols(), half.cols()) + measured.root.transpose() * H * half;
  covariance -= (half * S.ldlt().solve(half.transpose())).eval();
  covariance = (0.5 * (covariance + covariance.transpose())).eval();
  mean += covariance * H.transpose() * measured.pull;
}

RobotEstimate withEarlier(const RobotEstimate& estimate, const LastingEstimate& earlier,
                          const ErrorPriors& priors) {
  Gaussian<5 + kErrorCount> joint = estimate.joint<kErrorCount>();
  addEarlier(earlier, priors, {CartesianIndex::kSensorX, 5, kErrorCount}, joint.mean,
             joint.covariance);
  double& yaw = joint.mean(CartesianIndex::kSensorYaw);
  yaw = wrapAngle(yaw);
  return RobotEstimate::from<kErrorCount>(joint);
}

}  // namespace bearing_calibration::core
