#include "tools/paper/paper_experiment.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/paper_filter.h"

namespace bearing_calibration::core {
namespace {

constexpr int kPhi = PaperIndex::kPhi;

Vector5 paperTruth(const Vector5& cartesian) {
  return paperFromCartesian({cartesian, Matrix5::Zero()}).mean;
}

PaperFilter begunAt(const Vector5& mean, const Vector5& stddev) {
  return PaperFilter({mean, stddev.cwiseAbs2().asDiagonal(), false});
}

Eigen::Vector3d mountStddev(const PaperFilter& filter) {
  return filter.covariance().diagonal().tail<3>().cwiseSqrt();
}

/// The covariance of a filter that is linearised at the truth: the Cramer-Rao bound.
class Bound {
 public:
  Bound(const Vector5& truth, const Vector5& stddev) : filter_(begunAt(truth, stddev)) {}

  void step(const Observation& observation, bool has_moved, const Vector5& truth) {
    if (has_moved) filter_.predict(observation.motion);
    filter_.setMean(truth);
    filter_.update(azimuthFromPaper(truth).azimuth_rad, observation.azimuth_variance_rad2);
    filter_.setMean(truth);
  }
  Eigen::Vector3d stddev() const { return mountStddev(filter_); }

 private:
  PaperFilter filter_;
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

Eigen::Vector3d trueMount(const ObservationRun& run) {
  return paperTruth(run.truth.front()).tail<3>();
}

std::vector<PaperMoment> runPaperFilter(const ObservationRun& run, const PaperStart& start,
                                        double stated_stddev_rad) {
  const Vector5 first = paperTruth(run.truth.front());
  Vector5 guess = first;
  guess.tail<3>() = start.mount_guess;
  PaperFilter filter = begunAt(guess, start.stddev);
  Bound bound(first, start.stddev);
  Bound bound_unknown(first, nothingKnown());
  const Eigen::Vector3d mount = first.segment<3>(kPhi);
  constexpr std::size_t kMoments = 200;
  const std::size_t last = run.observations.size() - 1;
  const std::size_t step = std::max<std::size_t>(1, last / kMoments);
  std::vector<PaperMoment> moments;
  double distance_m = 0.0;
  const auto note = [&](std::size_t i) {
    const double time_s =
        secondsFromDuration(run.observations[i].stamp - run.observations.front().stamp);
    moments.push_back({i, time_s, distance_m, errorOf(filter.mean(), mount), mountStddev(filter),
                       bound.stddev(), bound_unknown.stddev()});
  };
  note(0);  // the start, before any bearing
  for (std::size_t i = 0; i < run.observations.size(); ++i) {
    const Observation& observation = run.observations[i];
    const Vector5 truth = paperTruth(run.truth[i]);
    const bool has_moved = i > 0;
    if (has_moved) {
      filter.predict(observation.motion);
      distance_m += observation.motion.distance_m;
    }
    filter.update(observation.azimuth_rad, stated_stddev_rad * stated_stddev_rad);
    bound.step(observation, has_moved, truth);
    bound_unknown.step(observation, has_moved, truth);
    if (i > 0 && (i % step == 0 || i == last)) note(i);
  }
  return moments;
}

}  // namespace bearing_calibration::core
