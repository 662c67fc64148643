#include "bearing_calibration/solve/metric_scale.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "bearing_calibration/common/chi_square.h"
#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {
namespace {

constexpr int kScales = placeOf<WheelScales>();
/// Errors whose priors know of the metric scale.
constexpr std::array<int, 3> kLengths = {kScales, kScales + 1, placeOf<WheelSeparation>()};

/// How the state changes where all lengths grow: its derivative by the logarithm of their unit.
StateVector growthAt(const StateLayout& layout, const StateVector& state) {
  StateVector growth = state;
  growth(kMountSize - 1) = 0.0;
  for (int error = 0; error < layout.errors; ++error) {
    double& change = growth(kMountSize + error);
    const bool is_length = std::count(kLengths.begin(), kLengths.end(), error) > 0;
    const bool is_height = error >= heightAt(0);
    if (is_length) change += 1.0;  // they are relative to one
    if (!is_length && !is_height) change = 0.0;
  }
  return growth;
}

}  // namespace

StateEstimate withoutLearntScale(const StateEstimate& estimate, const StateVector& at,
                                 const ErrorPriors& priors) {
  const auto isKnown = [&](int error) {
    return error >= estimate.layout.errors || !(priors.stddev(error) > 0.0);
  };
  if (std::any_of(kLengths.begin(), kLengths.end(), isKnown)) return estimate;
  std::vector<int> places;  // of what is not known for certain
  for (int i = 0; i < estimate.layout.size(); ++i) {
    if (estimate.covariance(i, i) > 0.0) places.push_back(i);
  }
  const auto size = static_cast<Eigen::Index>(places.size());
  // in standard deviations, so that all numbers can be compared
  const Eigen::MatrixXd P = estimate.covariance(places, places);
  const Eigen::VectorXd unit = P.diagonal().cwiseSqrt();
  const Eigen::VectorXd per_unit = unit.cwiseInverse();
  const Eigen::MatrixXd correlation = per_unit.asDiagonal() * P * per_unit.asDiagonal();
  const Eigen::MatrixXd information = inverseOf(correlation);
  const Eigen::VectorXd growth =
      per_unit.cwiseProduct(Eigen::VectorXd(growthAt(estimate.layout, at)(places)));

  Eigen::VectorXd prior = Eigen::VectorXd::Zero(size);  // its information ...
  Eigen::VectorXd pull = Eigen::VectorXd::Zero(size);   // ... and how the data pull against it
  for (Eigen::Index i = 0; i < size; ++i) {
    const int error = places[static_cast<std::size_t>(i)] - kMountSize;
    if (std::count(kLengths.begin(), kLengths.end(), error) == 0) continue;
    const double off = estimate.mean(kMountSize + error) - priors.mean(error);
    prior(i) = std::pow(unit(i) / priors.stddev(error), 2);
    pull(i) = prior(i) * off / unit(i);
  }
  const Eigen::VectorXd by_prior = prior.cwiseProduct(growth) / growth.cwiseAbs2().dot(prior);
  const Eigen::MatrixXd across =
      Eigen::MatrixXd::Identity(size, size) - growth * by_prior.transpose();
  Eigen::MatrixXd data = information;
  data.diagonal() -= prior;
  Eigen::MatrixXd projected = across.transpose() * data * across;
  projected.diagonal() += prior;
  const Eigen::MatrixXd covariance = inverseOf(projected);
  const Eigen::VectorXd shift = -(covariance * by_prior) * growth.dot(pull);

  StateEstimate known = estimate;
  known.mean(places) += unit.cwiseProduct(shift);
  known.covariance(places, places) = unit.asDiagonal() * covariance * unit.asDiagonal();
  symmetrise(&known.covariance);
  return known;
}

double doubtOfLengths(const ErrorEstimate& estimate, const ErrorPriors& priors) {
  constexpr double kByChance = 0.25;
  const auto isLookedFor = [&](int error) { return priors.stddev(error) > 0.0; };
  const auto looked_for = std::count_if(kLengths.begin(), kLengths.end(), isLookedFor);
  if (looked_for == 0) return 0.0;
  double chi_square = 0.0;
  for (const int error : kLengths) {
    if (!isLookedFor(error)) continue;
    chi_square += std::pow((estimate.mean(error) - priors.mean(error)) / priors.stddev(error), 2);
  }
  constexpr std::ptrdiff_t kRatios = kLengths.size() - 1;
  const auto degrees = static_cast<double>(std::min(looked_for, kRatios));
  return std::max(0.0, chi_square - chiSquareExceededBy(kByChance, degrees));
}

StateEstimate withDoubtOfLengths(StateEstimate estimate, const ErrorPriors& priors) {
  const double doubt = doubtOfLengths(estimate.errors(), priors);
  if (doubt == 0.0) return estimate;
  const StateMatrix P = estimate.covariance;
  for (const int error : kLengths) {
    if (error >= estimate.layout.errors || !(priors.stddev(error) > 0.0)) continue;
    const StateVector by_prior = P.col(kMountSize + error) / priors.stddev(error);
    estimate.covariance += doubt * by_prior * by_prior.transpose();
  }
  return estimate;
}

}  // namespace bearing_calibration::core
