#include "bearing_calibration/solve/noise_review.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/cancellation.h"
#include "bearing_calibration/solve/record_weights.h"
#include "bearing_calibration/solve/smoother.h"

namespace bearing_calibration::core {
namespace {

/// Natural logarithms of the bearings' and the wheels' factor; logits of the share of the bearings'
/// variance that lasts into the next bearing, and of how much of it does.
enum UnknownIndex : int { kBearing, kWheel, kShare, kCorrelation, kUnknowns };
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using UnknownsMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// What is known of the correlation beforehand: of any share and any length.
constexpr double kShareMean = -1.0;
constexpr double kCorrelationMean = 1.0;
constexpr double kLogitStddev = 1.5;

double fromLogit(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

/// Innovations of a record, and what it says of the robot in the end.
struct Filtered {
  std::vector<Innovation> innovations;
  StateEstimate last;
};

/// A record, linearised about the path of its fit, with the bearings' noise as a state of its own:
/// a first-order autoregression. A filter's pass for any levels of noise is cheap.
class LinearRecord {
 public:
  LinearRecord(const std::vector<Observation>& observations, const BatchEstimate& fit,
               const ErrorPriors& errors);

  /// @param gives_up_slips  that the fit gave up; else their motions are as good as all others
  Filtered filter(const Unknowns& unknowns, bool gives_up_slips) const;

 private:
  struct Step {
    LinearMotion motion;  ///< with the stated noise
    StateVector path;
    StateRow H;
    double residual_rad;  ///< at the path
    double stddev_rad;    ///< as stated
    double intervals;     ///< since the observation before it
    bool moves, slipped, use_bearing;
    struct Elevation {
      StateRow H;
      double residual_rad;
      double variance_rad2;
    };
    std::optional<Elevation> elevation;  ///< where it tells anything that is looked for
  };

  StateEstimate before_;
  std::vector<Step> steps_;
};

LinearRecord::LinearRecord(const std::vector<Observation>& observations, const BatchEstimate& fit,
                           const ErrorPriors& errors) {
  const StateLayout layout{errorsInUse(errors), 1};
  const RecordPath& path = fit.path;
  const double usual_interval_s = usualInterval(observations);
  steps_.reserve(observations.size());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& observation = observations[i];
    const StateVector at = path.stateAt(layout, i);
    const ExpectedAngle expected = expectAzimuth(layout, at, 0, observation.nearby);
    const double interval_s =
        i == 0 ? 0.0 : secondsFromDuration(observation.stamp - observations[i - 1].stamp);
    steps_.push_back(
        {lineariseMotion(layout, path.errors, path.points[i].lights_in_base, observation.motion,
                         path.points[i].motion_error),
         at, expected.J_angle_state, wrapAngle(observation.azimuth_rad - expected.angle_rad),
         std::sqrt(observation.azimuth_variance_rad2),
         usual_interval_s > 0.0 ? interval_s / usual_interval_s : 1.0, i > 0 || fit.beginning,
         fit.weights[i].slipped, fit.weights[i].use_bearing, std::nullopt});
    if (!errors.usesElevations() || !observation.elevation) continue;
    const ExpectedAngle over = expectElevation(layout, at, 0, observation.nearby);
    steps_.back().elevation = {
        over.J_angle_state, observation.elevation->angle_rad - over.angle_rad,
        fit.weights[i].elevation_doubt * observation.elevation->variance_rad2};
  }
  before_ = knownBeforehand(layout, path, kFreePass, errors, fit.known());
}

Filtered LinearRecord::filter(const Unknowns& unknowns, bool gives_up_slips) const {
  endIfCancelled();
  const double bearing_factor = std::exp(unknowns(kBearing));
  const double wheel_factor = std::exp(unknowns(kWheel));
  const double correlation = fromLogit(unknowns(kCorrelation));
  const double share = fromLogit(unknowns(kShare));
  Filtered filtered{{}, before_};
  filtered.innovations.reserve(steps_.size());
  StateEstimate& estimate = filtered.last;
  const int errors = estimate.layout.errors;
  // What lasts of the present bearing's noise, over its standard deviation, and its covariance with
  // the state.
  double noise = 0.0;
  double noise_variance = 1.0;
  StateVector shared = StateVector::Zero(estimate.layout.size());
  // The EKF's update by an angle of which so much is the noise that lasts.
  const auto takeIn = [&](const StateRow& H, double residual_rad, double lasting_stddev_rad,
                          double variance_rad2) {
    const StateVector PHt = estimate.covariance * H.transpose() + lasting_stddev_rad * shared;
    const double noise_PHt = H.dot(shared.transpose()) + lasting_stddev_rad * noise_variance;
    const Innovation innovation{
        residual_rad - lasting_stddev_rad * noise,
        H.dot(PHt.transpose()) + lasting_stddev_rad * noise_PHt + variance_rad2};
    const double pull = innovation.residual / innovation.variance;
    estimate.mean += pull * PHt;
    noise += pull * noise_PHt;
    estimate.covariance.noalias() -= PHt * (PHt / innovation.variance).transpose();
    shared -= noise_PHt / innovation.variance * PHt;
    noise_variance -= noise_PHt * noise_PHt / innovation.variance;
    return innovation;
  };
  for (const Step& step : steps_) {
    if (step.moves) {
      LinearMotion motion = step.motion;
      motion.covariance *= wheel_factor;
      if (step.slipped && gives_up_slips) motion.covariance += slipCovariance();
      propagate(motion, &estimate);
      shared.tail<2>() = (motion.R_end_start * shared.tail<2>()).eval() +
                         motion.J_lights_errors * shared.segment(kMountSize, errors);
    }
    const double kept = std::pow(correlation, step.intervals);
    noise *= kept;
    noise_variance = 1.0 - kept * kept * (1.0 - noise_variance);
    shared *= kept;
    if (!step.use_bearing) continue;
    const double variance_rad2 = std::pow(bearing_factor * step.stddev_rad, 2);
    const auto residual = [&](const StateRow& H, double at_path_rad) {
      return at_path_rad - H.dot((estimate.mean - step.path).transpose());
    };
    filtered.innovations.push_back(takeIn(step.H, residual(step.H, step.residual_rad),
                                          std::sqrt(share * variance_rad2),
                                          (1.0 - share) * variance_rad2));
    if (!step.elevation) continue;
    const auto& [H, at_path_rad, elevation_variance_rad2] = *step.elevation;
    takeIn(H, residual(H, at_path_rad), 0.0, elevation_variance_rad2);
  }
  symmetrise(&estimate.covariance);
  return filtered;
}

/// The levels that are likeliest under one supposition about slips.
struct Likeliest {
  Unknowns unknowns;
  UnknownsMatrix covariance;
  double cost;  ///< minus the logarithm of the likelihood
};

/// A cost at some levels.
struct Score {
  double cost = 0.0;
  Unknowns gradient = Unknowns::Zero();
  UnknownsMatrix information = UnknownsMatrix::Zero();
};

/// Fisher's scoring: derivatives of the innovations by small differences, their expected curvature.
class Levels {
 public:
  /// @param least_log_bearing  lower limit of that unknown
  Levels(const LinearRecord& record, const NoisePriors& priors, double least_log_bearing,
         bool gives_up_slips)
      : record_(record),
        mean_(0.0, 0.0, kShareMean, kCorrelationMean),
        stddev_(priors.bearing_stddev, priors.wheel_stddev, kLogitStddev, kLogitStddev),
        least_log_bearing_(least_log_bearing),
        gives_up_slips_(gives_up_slips) {}

  Likeliest find(Unknowns unknowns) const {
    constexpr int kMostSteps = 12;
    constexpr double kLongestStep = 1.0;
    constexpr double kSettled = 0.02;
    Likeliest likeliest{unknowns, UnknownsMatrix::Zero(), std::numeric_limits<double>::infinity()};
    for (int i = 0; i < kMostSteps; ++i) {
      const Score here = scoreAt(unknowns);
      if (here.cost < likeliest.cost) likeliest = {unknowns, covarianceOf(here), here.cost};
      const Unknowns step = (-here.information.ldlt().solve(here.gradient))
                                .cwiseMax(-kLongestStep)
                                .cwiseMin(kLongestStep);
      if (!(step.cwiseAbs().maxCoeff() >= kSettled)) break;
      // back to the best, where the last step was too long
      unknowns = here.cost > likeliest.cost ? Unknowns(0.5 * (unknowns + likeliest.unknowns))
                                            : Unknowns(unknowns + step);
      unknowns(kBearing) = std::max(unknowns(kBearing), least_log_bearing_);
    }
    return likeliest;
  }

 private:
  bool looksFor(int unknown) const { return stddev_(unknown) > 0.0; }

  std::vector<Innovation> innovationsAt(const Unknowns& unknowns) const {
    return record_.filter(unknowns, gives_up_slips_).innovations;
  }

  /// What the innovations alone say: their cost, its gradient and expected curvature.
  Score scoreOfInnovations(const Unknowns& unknowns) const {
    constexpr double kDifference = 1e-3;
    const std::vector<Innovation> here = innovationsAt(unknowns);
    std::array<std::vector<Innovation>, kUnknowns> moved;
    for (int k = 0; k < kUnknowns; ++k) {
      moved.at(static_cast<std::size_t>(k)) =
          looksFor(k) ? innovationsAt(unknowns + kDifference * Unknowns::Unit(k)) : here;
    }
    Score score;
    for (std::size_t i = 0; i < here.size(); ++i) {
      const auto& [residual, variance] = here[i];
      const double stddev = std::sqrt(variance);
      Unknowns by_variance, by_residual;
      for (int k = 0; k < kUnknowns; ++k) {
        const Innovation& other = moved.at(static_cast<std::size_t>(k))[i];
        by_variance(k) = std::log(other.variance / variance) / kDifference;
        by_residual(k) = (other.residual - residual) / (stddev * kDifference);
      }
      score.cost += 0.5 * (std::log(variance) + here[i].nis());
      score.gradient += 0.5 * (1.0 - here[i].nis()) * by_variance + residual / stddev * by_residual;
      score.information +=
          0.5 * by_variance * by_variance.transpose() + by_residual * by_residual.transpose();
    }
    return score;
  }

  /// The same with what was known beforehand; an unknown that is not looked for stays.
  Score scoreAt(const Unknowns& unknowns) const {
    Score score = scoreOfInnovations(unknowns);
    for (int k = 0; k < kUnknowns; ++k) {
      if (!looksFor(k)) {
        score.information(k, k) = 1.0;
        continue;
      }
      const double off = (unknowns(k) - mean_(k)) / stddev_(k);
      score.cost += 0.5 * off * off;
      score.gradient(k) += off / stddev_(k);
      score.information(k, k) += 1.0 / (stddev_(k) * stddev_(k));
    }
    return score;
  }

  UnknownsMatrix covarianceOf(const Score& score) const {
    UnknownsMatrix covariance = score.information.ldlt().solve(UnknownsMatrix::Identity());
    for (int k = 0; k < kUnknowns; ++k) {
      if (!looksFor(k)) covariance(k, k) = 0.0;
    }
    return covariance;
  }

  const LinearRecord& record_;
  Unknowns mean_;
  Unknowns stddev_;
  double least_log_bearing_;
  bool gives_up_slips_;
};

/// Mean and covariance over the levels, by two points of them for each unknown.
StateEstimate averageOver(const LinearRecord& record, const Likeliest& levels,
                          bool gives_up_slips) {
  constexpr int kPoints = 2 * kUnknowns;
  const UnknownsMatrix root =
      std::sqrt(static_cast<double>(kUnknowns)) *
      Eigen::SelfAdjointEigenSolver<UnknownsMatrix>(levels.covariance).operatorSqrt();
  const StateEstimate middle = record.filter(levels.unknowns, gives_up_slips).last;
  StateEstimate average = StateEstimate::zero(middle.layout);
  for (int i = 0; i < kPoints; ++i) {
    const double sign = i < kUnknowns ? 1.0 : -1.0;
    const StateEstimate point =
        record.filter(levels.unknowns + sign * root.col(i % kUnknowns), gives_up_slips).last;
    const StateVector off = point.mean - middle.mean;
    average.mean += off / kPoints;
    average.covariance += (point.covariance + off * off.transpose()) / kPoints;
  }
  average.covariance -= average.mean * average.mean.transpose();
  average.mean += middle.mean;
  return average;
}

/// Below it the bearings' level is not looked for.
double leastBearingLevel(const std::vector<Observation>& observations, const ErrorPriors& errors) {
  /// Of how neighbours differ, which wheels hardly touch: else noise that lasts is laid to them.
  constexpr double kShareOfDifferences = 0.7;
  double stated_rad2 = 0.0;
  for (const Observation& observation : observations) {
    stated_rad2 += observation.azimuth_variance_rad2 / static_cast<double>(observations.size());
  }
  // What a mirror's law leaves out is no noise: no scatter shows it.
  return std::max(kShareOfDifferences * bearingLevelFromDifferences(observations),
                  errors.geometry().unmodelledStddev() / std::sqrt(stated_rad2));
}

}  // namespace

NoiseReview reviewNoise(const std::vector<Observation>& observations, const BatchEstimate& fit,
                        const ErrorPriors& errors, const NoisePriors& priors,
                        const NoiseLevels& used) {
  constexpr double kCostOfSlip = 10.0;  // half the chi-square for which a fit gives a motion up
  const LinearRecord record(observations, fit, errors);
  Unknowns start;
  start << std::log(used.bearing.value), std::log(used.wheel.value), kShareMean, kCorrelationMean;
  const double least_log_bearing = priors.bearing_stddev > 0.0
                                       ? std::log(leastBearingLevel(observations, errors))
                                       : start(kBearing);
  bool gives_up_slips = true;
  Likeliest likeliest = Levels(record, priors, least_log_bearing, gives_up_slips).find(start);
  if (!fit.slips.empty()) {
    const Likeliest noisier = Levels(record, priors, least_log_bearing, false).find(start);
    const double cost = likeliest.cost + kCostOfSlip * static_cast<double>(fit.slips.size());
    if (noisier.cost < cost) {
      gives_up_slips = false;
      likeliest = noisier;
    }
  }
  const Unknowns stddev = likeliest.covariance.diagonal().cwiseSqrt();
  return {{{std::exp(likeliest.unknowns(kBearing)), stddev(kBearing)},
           {std::exp(likeliest.unknowns(kWheel)), stddev(kWheel)}},
          averageOver(record, likeliest, gives_up_slips)};
}

StateEstimate withItsNoise(StateEstimate estimate, const BatchEstimate& fit,
                           const NoiseReview& review) {
  const StateMatrix& before = fit.last.covariance;
  // in standard deviations of the fit, so that metres and radians can be compared
  const StateVector unit = before.diagonal().cwiseSqrt();
  const StateVector per_unit = (unit.array() > 0.0).select(unit.cwiseInverse(), 0.0);
  const Eigen::SelfAdjointEigenSolver<StateMatrix> solver(
      per_unit.asDiagonal() * (review.average.covariance - before) * per_unit.asDiagonal());
  const StateMatrix directions = unit.asDiagonal() * solver.eigenvectors();
  estimate.mean += review.average.mean - fit.last.mean;
  estimate.wrapYaw();
  estimate.covariance +=
      directions * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * directions.transpose();
  return estimate;
}

}  // namespace bearing_calibration::core
