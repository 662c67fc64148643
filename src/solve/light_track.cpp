#include "bearing_calibration/solve/light_track.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration::core {
namespace {

/// A light that is followed by bearings from a known mount.
class LightTracker {
 public:
  LightTracker(const Vector5& start, const ErrorVector& errors) : state_(start), errors_(errors) {
    constexpr double kStddevPerRange = 0.05;  // of a start from a good fit
    covariance_ = Eigen::Matrix2d::Identity() * std::pow(kStddevPerRange * rangeOf(start), 2);
  }

  void move(const Pose2& now_from_before, const Eigen::Matrix2d& noise) {
    const Eigen::Matrix2d R = rotation2(now_from_before.yaw_rad);
    state_.head<2>() = now_from_before * Eigen::Vector2d(state_.head<2>());
    covariance_ = R * covariance_ * R.transpose() + noise;
  }

  /// Updates the light, unless the observation is far off: then false.
  bool look(const Observation& observation) {
    constexpr double kGateSigmas = 4.0;
    constexpr double kGate_rad = 0.1;  // for what a start's mount may be wrong
    const Eigen::RowVector2d H = azimuthFromCartesian(state_).J_azimuth_state.head<2>();
    const double S = (H * covariance_ * H.transpose()).value() + observation.azimuth_variance_rad2;
    const double innovation = residualOf(observation, state_, errors_);
    if (std::abs(innovation) > kGateSigmas * std::sqrt(S) + kGate_rad) return false;
    // What is within the gate but unlikely pulls no more than this.
    constexpr double kLimitSigmas = 2.0;
    const double limit = kLimitSigmas * std::sqrt(S);
    const Eigen::Vector2d K = covariance_ * H.transpose() / S;
    state_.head<2>() += K * std::clamp(innovation, -limit, limit);
    covariance_ -= (K * S * K.transpose()).eval();
    return true;
  }

  /// The light is somewhere about here.
  void widen() {
    constexpr double kLost_rad = 0.3;  // more than one slip turns the robot
    covariance_ += Eigen::Matrix2d::Identity() * std::pow(kLost_rad * rangeOf(state_), 2);
  }

  Eigen::Vector2d light() const { return state_.head<2>(); }
  const Vector5& state() const { return state_; }

 private:
  static double rangeOf(const Vector5& state) {
    return (state.head<2>() - state.segment<2>(CartesianIndex::kSensorX)).norm();
  }

  Vector5 state_;
  ErrorVector errors_;
  Eigen::Matrix2d covariance_;
};

/// What a tracker made of one observation.
struct Point {
  std::size_t observation = 0;
  Vector5 state;
  bool seen = false;
};

/// A tracker, and what it made of the observations since it began.
class Trail {
 public:
  explicit Trail(const LightTracker& tracker) : tracker_(tracker) {}

  /// @param noise_at  of the motion, as a function of the light before it
  template <class NoiseAt>
  const Point& follow(std::size_t index, const Observation& observation,
                      const Pose2& now_from_before, const NoiseAt& noise_at) {
    tracker_.move(now_from_before, noise_at(tracker_.light()));
    const bool seen = tracker_.look(observation);
    points_.push_back({index, tracker_.state(), seen});
    seen_ += seen ? 1 : 0;
    far_off_ = seen ? 0 : far_off_ + 1;
    return points_.back();
  }

  /// The light is looked for about here.
  void widen() {
    tracker_.widen();
    far_off_ = 0;
  }

  /// Of the last `observations`, all but one at most were seen.
  bool sawTheLast(std::size_t observations) const {
    if (points_.size() < observations) return false;
    const auto last = points_.end() - static_cast<std::ptrdiff_t>(observations);
    return std::count_if(last, points_.end(), [](const Point& p) { return !p.seen; }) <= 1;
  }

  const LightTracker& tracker() const { return tracker_; }
  const std::vector<Point>& points() const { return points_; }
  int seen() const { return seen_; }
  int farOff() const { return far_off_; }  ///< observations in a row, until now

 private:
  LightTracker tracker_;
  std::vector<Point> points_;
  int seen_ = 0;
  int far_off_ = 0;
};

/// Follows the light in one direction of time. Where observation after observation is far off,
/// either a wheel has slipped, and the light is to be looked for anew; or another light was taken
/// for it, until it is seen again at its old place. Both are followed until it is known which.
class Pursuit {
 public:
  Pursuit(const std::vector<Observation>& observations, const RecordStart& start, LightTrack* track)
      : observations_(observations),
        track_(track),
        place_(LightTracker(start.state, start.errors)) {}

  /// @param noise_at  of the motion, as a function of the light before it
  template <class NoiseAt>
  void follow(std::size_t index, const Pose2& now_from_before, const NoiseAt& noise_at) {
    note(place_.follow(index, observations_[index], now_from_before, noise_at));
    if (!anew_ && place_.farOff() >= kLostAfter) lookAnew();
    if (!anew_) return;
    if (!is_first_) anew_->follow(index, observations_[index], now_from_before, noise_at);
    is_first_ = false;
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

  void note(const Point& point) {
    track_->states[point.observation] = point.state;
    track_->is_plausible[point.observation] = point.seen;
  }

  void lookAnew() {
    anew_.emplace(place_.tracker());
    anew_->widen();
    lost_ = place_.points().size() - kLostAfter;
    is_first_ = true;
  }

  /// After a slip.
  void moveOn() {
    for (std::size_t i = lost_; i < place_.points().size(); ++i) {
      track_->is_plausible[place_.points()[i].observation] = true;
    }
    for (const Point& point : anew_->points()) note(point);
    place_ = std::move(*anew_);
    anew_.reset();
  }

  const std::vector<Observation>& observations_;
  LightTrack* track_;
  Trail place_;
  std::optional<Trail> anew_;
  std::size_t lost_ = 0;   ///< of place_'s points, the first one since the light was lost
  bool is_first_ = false;  ///< anew_ begins at this observation, which is behind it
};

}  // namespace

Eigen::Matrix2d lightNoise(const OdometryIncrement& motion, const Eigen::Vector2d& light_at_end) {
  Eigen::Matrix<double, 2, 3> J_light_motion;
  J_light_motion << -rotation2(-motion.start_from_end.yaw_rad), -perpendicular(light_at_end);
  return J_light_motion * motion.covariance * J_light_motion.transpose();
}

LightTrack trackLight(const std::vector<Observation>& observations, const RecordStart& start) {
  LightTrack track{std::vector<Vector5>(observations.size(), start.state),
                   std::vector<bool>(observations.size(), true)};
  const auto motionTo = [&](std::size_t i) {
    return correctMotion<kErrorCount>(observations[i].motion, start.errors).start_from_end;
  };
  Pursuit forward(observations, start, &track);
  for (std::size_t i = start.observation + 1; i < observations.size(); ++i) {
    const Pose2 end_from_start = motionTo(i).inverse();
    forward.follow(i, end_from_start, [&](const Eigen::Vector2d& light) {
      return lightNoise(observations[i].motion, end_from_start * light);
    });
  }
  Pursuit backward(observations, start, &track);
  for (std::size_t i = start.observation; i > 0; --i) {
    const Pose2 start_from_end = motionTo(i);
    const Eigen::Matrix2d R = rotation2(start_from_end.yaw_rad);
    backward.follow(i - 1, start_from_end, [&](const Eigen::Vector2d& light) {
      return (R * lightNoise(observations[i].motion, light) * R.transpose()).eval();
    });
  }
  return track;
}

}  // namespace bearing_calibration::core
