#include <algorithm>
#include <cmath>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/robust_statistics.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/filter/robust_loss.h"
#include "bearing_calibration/output/sensor_check.h"
#include "bearing_calibration/solve/record_weights.h"

namespace bearing_calibration::core {
namespace {

/// What the wheels say a motion turns by, not wrapped.
double turnOf(const OdometryIncrement& motion) { return -motion.J_pose_wheels(2, 2); }

/// Turns on the spot in each of which a light's azimuth is
///     c - turn + sum over k of a_k cos(k turn) + b_k sin(k turn),
/// the turn 1 + `more` times what the wheels say, `late` before the stamp; least squares with
/// priors on all but c.
class SpinFit {
 public:
  SpinFit(const std::vector<Observation>& observations, std::vector<Stretch> spins)
      : observations_(observations), own_(spins.size(), Own::Zero()), spins_(std::move(spins)) {
    for (std::size_t k = 0; k < spins_.size(); ++k)
      own_[k](0) = observations_[spins_[k].begin].azimuth_rad;
  }

  TurningBearings run() {
    constexpr int kMostSteps = 20;
    constexpr double kSettled = 1e-6;
    for (int i = 0; i < kMostSteps; ++i) {
      weigh();
      if (step(variance_rad2_).norm() < kSettled) break;
    }
    return conclude();
  }

 private:
  static constexpr int kHarmonics = 3;  ///< beyond: below the noise of a light that is not touched
  static constexpr int kOwn = 1 + 2 * kHarmonics;
  enum Shared : int { kLate, kMore, kShared };
  static constexpr int kAll = kShared + kOwn;
  using Own = Eigen::Matrix<double, kOwn, 1>;
  using Row = Eigen::Matrix<double, 1, kAll>;
  using Normal = Eigen::Matrix<double, kAll, kAll>;

  /// One bearing against the model.
  struct Look {
    double residual_rad;
    Row J;
  };

  Look look(std::size_t i, double turn_rad, const Own& own) const {
    const OdometryWindow& nearby = observations_[i].nearby;
    const WheelDisplacement before = nearby.travelTo(-shared_(kLate));
    const WheelSpeeds speeds = nearby.speedsAt(-shared_(kLate));
    const double separation_m = nearby.wheelSeparation();
    const double wheels_turn = turn_rad + (before.right_m - before.left_m) / separation_m;
    const double scale = 1.0 + shared_(kMore);
    const double turn = scale * wheels_turn;
    Row J = Row::Zero();
    double expected_rad = own(0) - turn;
    double by_turn = -1.0;
    J(kShared) = 1.0;
    for (int k = 1; k <= kHarmonics; ++k) {
      const double c = std::cos(k * turn);
      const double s = std::sin(k * turn);
      const int at = 2 * k - 1;
      expected_rad += own(at) * c + own(at + 1) * s;
      by_turn += k * (own(at + 1) * c - own(at) * s);
      J.segment<2>(kShared + at) << c, s;
    }
    J(kMore) = by_turn * wheels_turn;
    J(kLate) = -by_turn * scale * (speeds.right_mps - speeds.left_mps) / separation_m;
    return {wrapAngle(observations_[i].azimuth_rad - expected_rad), J};
  }

  template <class Take>
  void forEachLook(std::size_t spin, const Take& take) const {
    double turn_rad = 0.0;
    for (std::size_t i = spins_[spin].begin; i < spins_[spin].end; ++i) {
      if (i > spins_[spin].begin) turn_rad += turnOf(observations_[i].motion);
      take(look(i, turn_rad, own_[spin]));
    }
  }

  /// The bearings' variance about the model as it stands.
  void weigh() {
    std::vector<double> residuals;
    for (std::size_t k = 0; k < spins_.size(); ++k)
      forEachLook(k, [&](const Look& seen) { residuals.push_back(seen.residual_rad); });
    constexpr double kLeast_rad = 1e-6;
    variance_rad2_ = std::pow(std::max(robustStddev(residuals), kLeast_rad), 2);
  }

  double sigmasOf(double residual_rad) const { return residual_rad / std::sqrt(variance_rad2_); }

  double weightOf(double residual_rad) const {
    constexpr double kHuberSigmas = 2.0;
    return 1.0 / huber(sigmasOf(residual_rad), kHuberSigmas).doubt;
  }

  /// The normal equations of one spin, the priors on its own numbers included.
  struct NormalEquations {
    Normal N = Normal::Zero();
    Eigen::Matrix<double, kAll, 1> pull = Eigen::Matrix<double, kAll, 1>::Zero();

    Eigen::MatrixXd ofOwn(const Eigen::MatrixXd& right) const {
      return solved(N.bottomRightCorner<kOwn, kOwn>(), right);
    }
  };
  NormalEquations normalOf(std::size_t spin, double variance_rad2) const {
    Own stddev;
    stddev << 10.0, 0.3, 0.3, 0.1, 0.1, 0.03, 0.03;  // [rad] sensors at a third of the range
    const Own precision = stddev.cwiseAbs2().cwiseInverse();
    NormalEquations normal;
    forEachLook(spin, [&](const Look& seen) {
      const double weight = weightOf(seen.residual_rad) / variance_rad2;
      normal.N += weight * seen.J.transpose() * seen.J;
      normal.pull += weight * seen.residual_rad * seen.J.transpose();
    });
    normal.N.diagonal().tail<kOwn>() += precision;
    constexpr int kSeries = kOwn - 1;  // c is pulled nowhere
    normal.pull.tail<kSeries>() -=
        precision.tail<kSeries>().cwiseProduct(own_[spin].tail<kSeries>());
    return normal;
  }

  /// One step of Gauss and Newton, each spin's own numbers eliminated: what the shared ones move
  /// by.
  Eigen::Vector2d step(double variance_rad2) {
    const Eigen::Vector2d stddev(0.3, 0.05);  // [s], [1]: nobody knows
    information_ = stddev.cwiseAbs2().cwiseInverse().asDiagonal();
    Eigen::Vector2d pull = -information_ * shared_;
    std::vector<NormalEquations> normals;
    for (std::size_t k = 0; k < spins_.size(); ++k) {
      normals.push_back(normalOf(k, variance_rad2));
      const auto& [N, g] = normals.back();
      const Eigen::MatrixXd eliminated = normals.back().ofOwn(N.bottomLeftCorner<kOwn, kShared>());
      information_ +=
          N.topLeftCorner<kShared, kShared>() - N.topRightCorner<kShared, kOwn>() * eliminated;
      pull += g.head<kShared>() - eliminated.transpose() * g.tail<kOwn>();
    }
    const Eigen::Vector2d moved = solved(information_, pull);
    for (std::size_t k = 0; k < spins_.size(); ++k) {
      const auto& [N, g] = normals[k];
      own_[k] += normals[k].ofOwn(g.tail<kOwn>() - N.bottomLeftCorner<kOwn, kShared>() * moved);
    }
    shared_ += moved;
    return moved;
  }

  TurningBearings conclude() {
    constexpr double kOutlierSigmas = 5.0;
    TurningBearings turning;
    double heading_variance_rad2 = 0.0;
    double squares = 1e-18;  // of a sensor without noise, too
    double products = 0.0;   // of neighbours
    for (std::size_t k = 0; k < spins_.size(); ++k) {
      double last = 0.0;
      forEachLook(k, [&](const Look& seen) {
        if (std::abs(sigmasOf(seen.residual_rad)) > kOutlierSigmas) return;
        const double residual = std::sqrt(weightOf(seen.residual_rad)) * seen.residual_rad;
        squares += residual * residual;
        products += residual * last;
        last = residual;
        ++turning.bearings;
      });
      for (std::size_t i = spins_[k].begin + 1; i < spins_[k].end; ++i) {
        turning.turn_rad += observations_[i].motion.rotation_rad;
        heading_variance_rad2 += observations_[i].motion.covariance(2, 2);
      }
    }
    constexpr double kMostCorrelation = 0.95;
    const double widening = wideningFor(std::clamp(products / squares, 0.0, kMostCorrelation));
    const double lost = widening * (kShared + static_cast<double>(kOwn * spins_.size()));
    turning.stddev_rad =
        std::sqrt(squares / std::max(turning.bearings - lost, 0.5 * turning.bearings));
    step(widening * turning.stddev_rad * turning.stddev_rad);
    const Eigen::Matrix2d covariance = inverseOf(information_);
    turning.late_s = {shared_(kLate), std::sqrt(covariance(kLate, kLate))};
    turning.more_turn = {shared_(kMore),
                         std::sqrt(covariance(kMore, kMore) +
                                   heading_variance_rad2 / std::pow(turning.turn_rad, 2))};
    constexpr double kUseful_s = 0.03;
    turning.tells_latency = turning.late_s.stddev < kUseful_s;
    return turning;
  }

  const std::vector<Observation>& observations_;
  Eigen::Vector2d shared_ = Eigen::Vector2d::Zero();
  std::vector<Own> own_;  ///< of each spin
  std::vector<Stretch> spins_;
  double variance_rad2_ = 1.0;
  Eigen::Matrix2d information_;  ///< of the shared ones
};

/// Turns on the spot with the stops in them, in parts of two turns at most: what else the robot did
/// meanwhile, and the wheels' noise, must not add up.
std::vector<Stretch> spinsOf(const std::vector<Observation>& observations) {
  constexpr double kLever_m = 0.03;  // of the turn's centre off the axis
  constexpr double kSpeed_mps = 5e-3;
  constexpr double kLongest_rad = 4.0 * kPi;
  constexpr double kShortest_rad = kPi;
  constexpr std::size_t kFewestInSpin = 15;
  std::vector<Stretch> spins;
  for (const Stretch& whole : stretchesOf(observations, [&](std::size_t i) {
         const OdometryIncrement& motion = observations[i].motion;
         return motion.distance_m <=
                kLever_m * motion.rotation_rad +
                    kSpeed_mps * secondsBetween(observations[i - 1], observations[i]);
       })) {
    Stretch part{whole.begin, whole.begin};
    double turn_rad = 0.0;
    const auto keep = [&] {
      if (turn_rad >= kShortest_rad && part.size() >= kFewestInSpin) spins.push_back(part);
    };
    for (std::size_t i = whole.begin + 1; i < whole.end; ++i) {
      turn_rad += observations[i].motion.rotation_rad;
      part.end = i + 1;
      if (turn_rad < kLongest_rad) continue;
      keep();
      part = {i, i + 1};
      turn_rad = 0.0;
    }
    keep();
  }
  return spins;
}

}  // namespace

std::optional<TurningBearings> checkTurning(const std::vector<Observation>& observations) {
  constexpr double kFullTurn_rad = 2.0 * kPi;
  constexpr std::size_t kFewestBearings = 30;
  const std::vector<Stretch> spins = spinsOf(observations);
  std::size_t bearings = 0;
  double turn_rad = 0.0;
  for (const Stretch& spin : spins) {
    bearings += spin.size();
    for (std::size_t i = spin.begin + 1; i < spin.end; ++i)
      turn_rad += observations[i].motion.rotation_rad;
  }
  if (bearings < kFewestBearings || turn_rad < kFullTurn_rad) return std::nullopt;
  return SpinFit(observations, spins).run();
}

}  // namespace bearing_calibration::core
