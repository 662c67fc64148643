#include "bearing_calibration/solve/record_track.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/motion_model.h"

namespace bearing_calibration::core {
namespace {

/// A motion the other way round.
OdometryIncrement reversed(const OdometryIncrement& motion) {
  OdometryIncrement reversed = motion;
  reversed.start_from_end = motion.start_from_end.inverse();
  Eigen::Matrix3d J_reversed_motion = -Eigen::Matrix3d::Identity();
  J_reversed_motion.topLeftCorner<2, 2>() = -rotation2(reversed.start_from_end.yaw_rad);
  J_reversed_motion.topRightCorner<2, 1>() = -perpendicular(reversed.start_from_end.position_m);
  reversed.covariance = J_reversed_motion * motion.covariance * J_reversed_motion.transpose();
  return reversed;
}

/// A light that is followed by bearings from a known mount.
class LightTracker {
 public:
  LightTracker(const Eigen::Vector2d& light_in_base, const RecordStart& start)
      : estimate_(StateEstimate::zero({0, 1})), errors_(start.errors) {
    constexpr double kStddevPerRange = 0.05;  // of a start from a good fit
    estimate_.mean << start.mount, light_in_base;
    widen(kStddevPerRange);
  }

  void move(const OdometryIncrement& motion) { propagate(motion, &estimate_); }

  /// Updates the light, unless the observation is far off: then false.
  bool look(const Observation& observation) {
    constexpr double kGateSigmas = 4.0;
    constexpr double kGate_rad = 0.1;  // for what a start's mount may be wrong
    const StateLayout& layout = estimate_.layout;
    const ExpectedAngle expected = expectAzimuth(layout, estimate_.mean, 0, {});
    ScalarUpdate update =
        prepareUpdate(expected.J_angle_state, residualOf(observation, cartesian(), errors_),
                      observation.azimuth_variance_rad2, estimate_);
    auto& [residual, variance] = update.innovation;
    if (std::abs(residual) > kGateSigmas * std::sqrt(variance) + kGate_rad) return false;
    // What is within the gate but unlikely pulls no more than this.
    constexpr double kLimitSigmas = 2.0;
    const double limit = kLimitSigmas * std::sqrt(variance);
    residual = std::clamp(residual, -limit, limit);
    apply(update, &estimate_);
    return true;
  }

  /// The light is somewhere about here.
  void widen() {
    constexpr double kLost_rad = 0.3;  // more than one slip turns the robot
    widen(kLost_rad);
  }

  Eigen::Vector2d light() const { return cartesian().head<2>(); }

 private:
  Vector5 cartesian() const { return cartesianOf(estimate_.layout, estimate_.mean, 0); }
  void widen(double stddev_per_range) {
    const Vector5 state = cartesian();
    const double stddev_m =
        stddev_per_range * (state.head<2>() - state.segment<2>(CartesianIndex::kSensorX)).norm();
    estimate_.covariance.bottomRightCorner<2, 2>() +=
        stddev_m * stddev_m * Eigen::Matrix2d::Identity();
  }

  StateEstimate estimate_;  ///< the mount is certain
  ErrorVector errors_;
};

/// What a tracker made of one observation.
struct TrailPoint {
  std::size_t observation = 0;
  Eigen::Vector2d light;
  bool seen = false;
};

/// A tracker, and what it made of the observations since it began.
class Trail {
 public:
  explicit Trail(const LightTracker& tracker) : tracker_(tracker) {}

  void move(const OdometryIncrement& motion) { tracker_.move(motion); }

  /// @param is_own  of this light, and not of another one
  const TrailPoint& follow(std::size_t index, const Observation& observation, bool is_own) {
    const bool seen = !is_own || tracker_.look(observation);
    if (is_own) {
      own_.push_back(points_.size());
      seen_ += seen ? 1 : 0;
      far_off_ = seen ? 0 : far_off_ + 1;
    }
    points_.push_back({index, tracker_.light(), seen});
    return points_.back();
  }

  /// The light is looked for about here.
  void widen() {
    tracker_.widen();
    far_off_ = 0;
  }

  /// Of the last `observations` of this light, all but one at most were seen.
  bool sawTheLast(std::size_t observations) const {
    if (own_.size() < observations) return false;
    const auto last = own_.end() - static_cast<std::ptrdiff_t>(observations);
    return std::count_if(last, own_.end(), [this](std::size_t i) { return !points_[i].seen; }) <= 1;
  }

  const LightTracker& tracker() const { return tracker_; }
  const std::vector<TrailPoint>& points() const { return points_; }
  /// Of the points, where the last so many observations of this light begin.
  std::size_t beginOfLast(std::size_t observations) const {
    return own_[own_.size() - observations];
  }
  int seen() const { return seen_; }
  int farOff() const { return far_off_; }  ///< observations in a row, until now

 private:
  LightTracker tracker_;
  std::vector<TrailPoint> points_;
  std::vector<std::size_t> own_;  ///< of the points, those that this light is seen at
  int seen_ = 0;
  int far_off_ = 0;
};

/// Follows one light in one direction of time. Where observation after observation is far off,
/// either a wheel has slipped, and the light is to be looked for anew; or another light was taken
/// for it, until it is seen again at its old place. Both are followed until it is known which.
class Pursuit {
 public:
  Pursuit(const std::vector<Observation>& observations, int light, const RecordStart& start,
          RecordTrack* track)
      : observations_(observations),
        light_(light),
        track_(track),
        place_(LightTracker(start.lights_in_base.col(light), start)) {}

  /// @param motion  to this observation from the one followed before
  void follow(std::size_t index, const OdometryIncrement& motion) {
    const bool is_own = observations_[index].light == light_;
    place_.move(motion);
    if (anew_) anew_->move(motion);
    note(place_.follow(index, observations_[index], is_own));
    if (anew_) anew_->follow(index, observations_[index], is_own);
    if (!is_own) return;
    if (!anew_ && place_.farOff() >= kLostAfter) lookAnew();
    if (!anew_) return;
    if (place_.sawTheLast(kLostAfter)) {
      anew_.reset();
    } else if (anew_->seen() >= kSure) {
      moveOn();
    } else if (anew_->farOff() >= kLostAfter) {
      anew_->widen();
    }
  }

 private:
  static constexpr int kLostAfter = 5;  // 20 % outliers: so many in a row are one in 3000
  static constexpr int kSure = 40;      // observations: so long no other light is taken for it

  bool isOwn(const TrailPoint& point) const {
    return observations_[point.observation].light == light_;
  }

  void note(const TrailPoint& point) {
    track_->path.points[point.observation].lights_in_base.col(light_) = point.light;
    if (isOwn(point)) track_->is_plausible[point.observation] = point.seen;
  }

  /// From the next observation on: this one is behind it.
  void lookAnew() {
    anew_.emplace(place_.tracker());
    anew_->widen();
    lost_ = place_.beginOfLast(kLostAfter);
  }

  /// After a slip.
  void moveOn() {
    for (std::size_t i = lost_; i < place_.points().size(); ++i) {
      const TrailPoint& point = place_.points()[i];
      if (isOwn(point)) track_->is_plausible[point.observation] = true;
    }
    for (const TrailPoint& point : anew_->points()) note(point);
    place_ = std::move(*anew_);
    anew_.reset();
  }

  const std::vector<Observation>& observations_;
  int light_;
  RecordTrack* track_;
  Trail place_;
  std::optional<Trail> anew_;
  std::size_t lost_ = 0;  ///< of place_'s points, the first one since the light was lost
};

}  // namespace

RecordStart::RecordStart(const StateEstimate& estimate, std::size_t at)
    : mount(estimate.mount().mean),
      errors(robotErrorsOf(estimate.layout, estimate.mean)),
      lights_in_base(
          estimate.mean.tail(2 * estimate.layout.lights).reshaped(2, estimate.layout.lights)),
      observation(at) {}

RecordTrack trackLights(const std::vector<Observation>& observations, const RecordStart& start) {
  RecordTrack track{{std::vector<PathPoint>(observations.size(), PathPoint{start.lights_in_base}),
                     start.mount, start.errors},
                    std::vector<bool>(observations.size(), true)};
  const auto motionTo = [&](std::size_t i) {
    OdometryIncrement motion = observations[i].motion;
    motion.start_from_end = correctMotion(motion, start.errors).start_from_end;
    return motion;
  };
  for (int light = 0; light < track.path.lights(); ++light) {
    Pursuit forward(observations, light, start, &track);
    for (std::size_t i = start.observation + 1; i < observations.size(); ++i) {
      forward.follow(i, motionTo(i));
    }
    Pursuit backward(observations, light, start, &track);
    for (std::size_t i = start.observation; i > 0; --i) {
      backward.follow(i - 1, reversed(motionTo(i)));
    }
  }
  return track;
}

}  // namespace bearing_calibration::core
