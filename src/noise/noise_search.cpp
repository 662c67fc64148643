#include "bearing_calibration/noise/noise_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "bearing_calibration/common/symmetric.h"

namespace bearing_calibration::core {
namespace {

/// What is known of the correlation beforehand: of any share and any length.
constexpr double kShareMean = 0.0;
constexpr double kShareStddev = 1.8;  // uniform from 0 to 1
constexpr double kCorrelationMean = 1.0;
constexpr double kCorrelationStddev = 1.5;
const double kLightSizeMean = std::log(NoisePriors::kUsualLightSize_m);

/// A cost at some levels.
struct Score {
  double cost = 0.0;
  NoiseUnknowns gradient = NoiseUnknowns::Zero();
  NoiseUnknownsMatrix information = NoiseUnknownsMatrix::Zero();
  NoiseUnknowns scatter = NoiseUnknowns::Ones();  ///< of the gradient, over the information

  /// What innovations tell that scatter so.
  NoiseInformation told(const NoiseUnknowns& at) const {
    const NoiseUnknowns part = scatter.cwiseInverse();
    const NoiseUnknowns root = part.cwiseSqrt();
    const NoiseUnknownsMatrix matrix = root.asDiagonal() * information * root.asDiagonal();
    return {matrix, matrix * at - part.cwiseProduct(gradient)};
  }
};

/// Gradients of parts of a record scatter as the information says where the noise is the same in
/// all of them; else the record tells so much less.
class GradientScatter {
 public:
  explicit GradientScatter(std::size_t innovations) : innovations_(innovations) {
    parts_.fill(NoiseUnknowns::Zero());
  }

  void add(std::size_t innovation, const NoiseUnknowns& gradient) {
    parts_.at(innovation * kParts / innovations_) += gradient;
  }

  /// Variances of the gradient over those that the information says, each at least 1.
  NoiseUnknowns over(const NoiseUnknownsMatrix& information) const {
    NoiseUnknowns mean = NoiseUnknowns::Zero();
    for (const NoiseUnknowns& part : parts_) mean += part / kParts;
    NoiseUnknowns variance = NoiseUnknowns::Zero();
    for (const NoiseUnknowns& part : parts_) {
      variance += kParts / (kParts - 1.0) * (part - mean).cwiseAbs2();
    }
    NoiseUnknowns ratio = NoiseUnknowns::Ones();
    for (int k = 0; k < kNoiseUnknowns; ++k) {
      if (information(k, k) > 0.0) ratio(k) = std::max(1.0, variance(k) / information(k, k));
    }
    return ratio;
  }

 private:
  static constexpr std::size_t kParts = 20;
  std::size_t innovations_;
  std::array<NoiseUnknowns, kParts> parts_;
};

/// Fisher's scoring: derivatives of the innovations by small differences, their expected curvature.
class Levels {
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  static constexpr double kLeastSigmas = 3.0;  // no robot's wheels are better

 public:
  Levels(const NoiseRecord& record, const NoisePriors& priors, const NoiseInformation& told_before,
         double least_log_bearing, bool gives_up_slips)
      : record_(record), told_before_(told_before), gives_up_slips_(gives_up_slips) {
    mean_ << 0.0, 0.0, kShareMean, kCorrelationMean, kLightSizeMean;
    stddev_ << priors.bearing_stddev, priors.wheel_stddev, kShareStddev, kCorrelationStddev,
        priors.lightSizeStddev();
    least_.setConstant(-kInfinity);
    least_(kBearingLevel) = least_log_bearing;
    least_(kWheelLevel) = -kLeastSigmas * priors.wheel_stddev;
  }

  LikeliestNoise find(NoiseUnknowns unknowns) const {
    constexpr int kMostSteps = 12;
    constexpr double kLongestStep = 2.0;
    constexpr double kSettled = 0.02;
    unknowns = unknowns.cwiseMax(least_);
    LikeliestNoise likeliest{unknowns, NoiseUnknownsMatrix::Zero(), kInfinity, NoiseInformation()};
    for (int i = 0; i < kMostSteps; ++i) {
      const Score innovations = scoreOfInnovations(unknowns);
      const Score here = withWhatIsKnown(innovations, unknowns);
      if (here.cost < likeliest.cost) {
        const NoiseInformation told = innovations.told(unknowns);
        likeliest = {unknowns,
                     covarianceOf(here.information - innovations.information + told.matrix),
                     here.cost, told};
      }
      NoiseUnknowns step = stepFrom(here, unknowns);
      const double length = step.cwiseAbs().maxCoeff();
      if (!(length >= kSettled)) break;
      step *= std::min(1.0, kLongestStep / length);  // still downhill
      // back to the best, where the last step was too long
      unknowns = here.cost > likeliest.cost ? NoiseUnknowns(0.5 * (unknowns + likeliest.unknowns))
                                            : NoiseUnknowns(unknowns + step);
      unknowns = unknowns.cwiseMax(least_);
    }
    return likeliest;
  }

 private:
  bool looksFor(int unknown) const { return stddev_(unknown) > 0.0; }

  /// To the minimum, but for those at their lower limit that would go beyond it.
  NoiseUnknowns stepFrom(Score score, const NoiseUnknowns& unknowns) const {
    NoiseUnknowns step = -solved(score.information, score.gradient);
    for (int k = 0; k < kNoiseUnknowns; ++k) {
      if (unknowns(k) > least_(k) || step(k) >= 0.0) continue;
      score.information.row(k).setZero();
      score.information.col(k).setZero();
      score.information(k, k) = 1.0;
      score.gradient(k) = 0.0;
      step = -solved(score.information, score.gradient);
    }
    return step;
  }

  std::vector<Innovation> innovationsAt(const NoiseUnknowns& unknowns) const {
    return record_.filter(unknowns, gives_up_slips_, record_.size()).innovations;
  }

  /// What the innovations alone say: their cost, its gradient and expected curvature.
  Score scoreOfInnovations(const NoiseUnknowns& unknowns) const {
    constexpr double kDifference = 1e-3;
    const std::vector<Innovation> here = innovationsAt(unknowns);
    std::array<std::vector<Innovation>, kNoiseUnknowns> moved;
    for (int k = 0; k < kNoiseUnknowns; ++k) {
      moved.at(static_cast<std::size_t>(k)) =
          looksFor(k) ? innovationsAt(unknowns + kDifference * NoiseUnknowns::Unit(k)) : here;
    }
    Score score;
    GradientScatter scatter(here.size());
    for (std::size_t i = 0; i < here.size(); ++i) {
      const auto& [residual, variance] = here[i];
      const double stddev = std::sqrt(variance);
      NoiseUnknowns by_variance, by_residual;
      for (int k = 0; k < kNoiseUnknowns; ++k) {
        const Innovation& other = moved.at(static_cast<std::size_t>(k))[i];
        by_variance(k) = std::log(other.variance / variance) / kDifference;
        by_residual(k) = (other.residual - residual) / (stddev * kDifference);
      }
      score.cost += 0.5 * (std::log(variance) + here[i].nis());
      const NoiseUnknowns gradient =
          0.5 * (1.0 - here[i].nis()) * by_variance + residual / stddev * by_residual;
      scatter.add(i, gradient);
      score.gradient += gradient;
      score.information +=
          0.5 * by_variance * by_variance.transpose() + by_residual * by_residual.transpose();
    }
    score.scatter = scatter.over(score.information);
    return score;
  }

  /// The same with what was known beforehand; an unknown that is not looked for stays.
  Score withWhatIsKnown(Score score, const NoiseUnknowns& unknowns) const {
    score.cost += unknowns.dot(0.5 * told_before_.matrix * unknowns - told_before_.times_mean);
    score.gradient += told_before_.matrix * unknowns - told_before_.times_mean;
    score.information += told_before_.matrix;
    for (int k = 0; k < kNoiseUnknowns; ++k) {
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

  NoiseUnknownsMatrix covarianceOf(const NoiseUnknownsMatrix& information) const {
    NoiseUnknownsMatrix covariance = inverseOf(information);
    for (int k = 0; k < kNoiseUnknowns; ++k) {
      if (!looksFor(k)) covariance(k, k) = 0.0;
    }
    return covariance;
  }

  const NoiseRecord& record_;
  const NoiseInformation& told_before_;
  NoiseUnknowns mean_;
  NoiseUnknowns stddev_;
  NoiseUnknowns least_;  ///< lower limits
  bool gives_up_slips_;
};

}  // namespace

NoiseUnknowns unknownsWith(const NoiseLevels& levels) {
  NoiseUnknowns unknowns;
  unknowns << std::log(levels.bearing.value), std::log(levels.wheel.value), kShareMean,
      kCorrelationMean,
      levels.light_size.stddev_m > 0.0 ? std::log(levels.light_size.stddev_m) : kLightSizeMean;
  return unknowns;
}

LikeliestNoise findNoise(const NoiseRecord& record, const NoisePriors& priors,
                         const NoiseInformation& told_before, double least_log_bearing,
                         bool gives_up_slips, const NoiseUnknowns& start) {
  return Levels(record, priors, told_before, least_log_bearing, gives_up_slips).find(start);
}

}  // namespace bearing_calibration::core
