#include "tools/paper_experiment.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"
#include "bearing_calibration/filter/ekf.h"

namespace bearing_calibration {
namespace {

constexpr int kPhi = PaperIndex::kPhi;

Vector5 paperTruth(const Vector5& cartesian) {
  return paperFromCartesian({cartesian, Matrix5::Zero()}).mean;
}

/// The paper's filter in its own chart, which it may begin at rho = 0.
class PaperEkf {
 public:
  PaperEkf(const Vector5& mean, const Vector5& stddev)
      : state_{mean, stddev.cwiseAbs2().asDiagonal()} {}

  void predict(const OdometryIncrement& motion) {
    const Propagation next = propagatePaper(state_.mean, motion);
    state_.mean = next.state;
    state_.covariance = next.J_state_state * state_.covariance * next.J_state_state.transpose() +
                        next.J_state_motion * motion.covariance * next.J_state_motion.transpose();
  }
  void update(double azimuth_rad, double variance_rad2) {
    const AzimuthModel expected = azimuthFromPaper(state_.mean);
    state_ = updateScalar<5>(state_, expected.J_azimuth_state,
                             wrapAngle(azimuth_rad - expected.azimuth_rad), variance_rad2);
  }
  /// Goes on from the truth, with the covariance as it is: what is left is the bound.
  void setMean(const Vector5& mean) { state_.mean = mean; }

  const Gaussian<5>& state() const { return state_; }
  Eigen::Vector3d mountStddev() const { return state_.covariance.diagonal().tail<3>().cwiseSqrt(); }

 private:
  Gaussian<5> state_;
};

/// The covariance of a filter that is linearised at the truth: the Cramer-Rao bound.
class Bound {
 public:
  Bound(const Vector5& truth, const Vector5& stddev) : filter_(truth, stddev) {}

  void step(const Sight& sight, bool has_moved, const Vector5& truth) {
    if (has_moved) filter_.predict(sight.motion);
    filter_.setMean(truth);
    filter_.update(azimuthFromPaper(truth).azimuth_rad, sight.azimuth_variance_rad2);
    filter_.setMean(truth);
  }
  Eigen::Vector3d stddev() const { return filter_.mountStddev(); }

 private:
  PaperEkf filter_;
};

/// (phi, rho, psi) and (phi + pi, -rho, psi - pi) are the same mount: the error is that of the name
/// whose phi is nearer to the truth.
Eigen::Vector3d errorOf(const Vector5& estimate, const Eigen::Vector3d& truth) {
  Eigen::Vector3d mount = estimate.tail<3>();
  if (std::cos(mount(0) - truth(0)) < 0.0) {
    mount = Eigen::Vector3d(mount(0) + kPi, -mount(1), mount(2) - kPi);
  }
  const Eigen::Vector3d error = mount - truth;
  return {wrapAngle(error(0)), error(1), wrapAngle(error(2))};
}

/// Nothing known: wider than any room and any mount.
Vector5 nothingKnown() {
  constexpr double kAnyDistance_m = 100.0;
  constexpr double kAnyMount_m = 10.0;
  constexpr double kAnyAngle_rad = 100.0;
  return (Vector5() << kAnyDistance_m, kAnyAngle_rad, kAnyAngle_rad, kAnyMount_m, kAnyAngle_rad)
      .finished();
}

}  // namespace

Eigen::Vector3d trueMount(const SightRun& run) { return paperTruth(run.truth.front()).tail<3>(); }

std::vector<PaperMoment> runPaperFilter(const SightRun& run, const PaperStart& start,
                                        double told_stddev_rad) {
  const Vector5 first = paperTruth(run.truth.front());
  Vector5 guess = first;
  guess.tail<3>() = start.mount_guess;
  PaperEkf filter(guess, start.stddev);
  Bound bound(first, start.stddev);
  Bound bound_unknown(first, nothingKnown());
  const Eigen::Vector3d mount = first.segment<3>(kPhi);
  constexpr std::size_t kMoments = 200;
  const std::size_t last = run.sights.size() - 1;
  const std::size_t step = std::max<std::size_t>(1, last / kMoments);
  std::vector<PaperMoment> moments;
  double distance_m = 0.0;
  const auto note = [&](std::size_t i) {
    const double time_s = secondsFromDuration(run.sights[i].stamp - run.sights.front().stamp);
    moments.push_back({i, time_s, distance_m, errorOf(filter.state().mean, mount),
                       filter.mountStddev(), bound.stddev(), bound_unknown.stddev()});
  };
  note(0);  // the start, before any bearing
  for (std::size_t i = 0; i < run.sights.size(); ++i) {
    const Sight& sight = run.sights[i];
    const Vector5 truth = paperTruth(run.truth[i]);
    const bool has_moved = i > 0;
    if (has_moved) {
      filter.predict(sight.motion);
      distance_m += sight.motion.distance_m;
    }
    filter.update(sight.azimuth_rad, told_stddev_rad * told_stddev_rad);
    bound.step(sight, has_moved, truth);
    bound_unknown.step(sight, has_moved, truth);
    if (i > 0 && (i % step == 0 || i == last)) note(i);
  }
  return moments;
}

}  // namespace bearing_calibration
