#include "bearing_calibration/filter/lasting_estimate.h"

#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {
namespace {

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
  const SymmetricEigen axes = eigenOf(0.5 * (scaled + scaled.transpose()));
  const Eigen::VectorXd values = axes.values.cwiseMax(0.0);
  Eigen::VectorXd along = axes.vectors.transpose() * unit.cwiseProduct(pull);
  along = (values.array() > kRounding).select(along, 0.0);
  const Eigen::MatrixXd directions = unit.cwiseInverse().asDiagonal() * axes.vectors;
  return {directions * along, directions * values.cwiseSqrt().asDiagonal()};
}

/// Places, the same in both, of the mount and of the errors that both look for.
std::vector<int> sharedPlaces(const StateEstimate& earlier, const ErrorPriors& priors,
                              const StateLayout& layout) {
  std::vector<int> places;
  for (int i = 0; i < layout.lastingSize(); ++i) {
    const bool is_shared =
        i < kMountSize || (earlier.covariance(i, i) > 0.0 && priors.stddev(i - kMountSize) > 0.0);
    if (is_shared) places.push_back(i);
  }
  return places;
}

}  // namespace

StateEstimate lastingPart(const StateEstimate& estimate) {
  StateEstimate lasting = StateEstimate::zero({kErrorCount, 0});
  const int size = estimate.layout.lastingSize();
  lasting.mean.head(size) = estimate.mean.head(size);
  lasting.covariance.topLeftCorner(size, size) = estimate.covariance.topLeftCorner(size, size);
  for (int i = 0; i < kErrorCount; ++i) {
    if (lasts(i)) continue;
    lasting.mean(kMountSize + i) = 0.0;
    lasting.covariance.row(kMountSize + i).setZero();
    lasting.covariance.col(kMountSize + i).setZero();
  }
  return lasting;
}

StateEstimate lastingPart(const MountEstimate& mount) {
  return lastingPart(StateEstimate{{}, mount.mean, mount.covariance});
}

std::vector<std::string> lastingNames() {
  std::vector<std::string> names = {"x [m]", "y [m]", "yaw [rad]"};
  for (const Quantity& error : errorQuantities()) names.push_back(labelOf(error));
  return names;
}

void addEarlier(const StateEstimate& earlier, const ErrorPriors& priors, StateEstimate* estimate) {
  const std::vector<int> places = sharedPlaces(earlier, priors, estimate->layout);
  const Eigen::VectorXd off_all = earlier.mean.head(estimate->layout.lastingSize()) -
                                  estimate->mean.head(estimate->layout.lastingSize());
  const Eigen::MatrixXd known = earlier.covariance(places, places);
  Eigen::VectorXd off = off_all(places);
  off.head<kMountSize>() = mountDifference(earlier.mount().mean, estimate->mount().mean);
  Eigen::MatrixXd information = inverseOf(known);
  Eigen::VectorXd pull = information * off;
  for (Eigen::Index i = kMountSize; i < known.rows(); ++i) {
    const int place = places[static_cast<std::size_t>(i)];
    const int error = place - kMountSize;
    const double beforehand = 1.0 / (priors.stddev(error) * priors.stddev(error));
    information(i, i) -= beforehand;
    pull(i) -= beforehand * (priors.mean(error) - estimate->mean(place));
  }
  const Knowledge measured = positivePart(information, pull, known.diagonal().cwiseSqrt());
  StateMatrix& P = estimate->covariance;
  const Eigen::MatrixXd P_H = P(Eigen::all, places);
  const Eigen::MatrixXd half = P_H * measured.root;
  const Eigen::MatrixXd S = Eigen::MatrixXd::Identity(half.cols(), half.cols()) +
                            measured.root.transpose() * half(places, Eigen::all);
  P -= half * solved(S, half.transpose());
  symmetrise(&P);
  estimate->mean += P(Eigen::all, places) * measured.pull;
  estimate->wrapYaw();
}

}  // namespace bearing_calibration::core
