#include "bearing_calibration/calibration/light_track.h"

#include <algorithm>
#include <cmath>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/filter/bearing_model.h"

namespace bearing_calibration {
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

  /// Updates the light, unless the sight is far off: then false. After several of those in a row
  /// the light itself is looked for anew.
  bool look(const Sight& sight) {
    constexpr double kGateSigmas = 4.0;
    constexpr double kGate_rad = 0.1;  // for what a start's mount may be wrong
    constexpr int kLostAfter = 5;      // with 20 % outliers, that many in a row are one in 3000
    constexpr double kLost_rad = 0.3;  // more than one slip turns the robot
    const Eigen::RowVector2d H = azimuthFromCartesian(state_).J_azimuth_state.head<2>();
    const double S = (H * covariance_ * H.transpose()).value() + sight.azimuth_variance_rad2;
    const double innovation = residualOf(sight, state_, errors_);
    if (std::abs(innovation) > kGateSigmas * std::sqrt(S) + kGate_rad) {
      if (++far_off_ >= kLostAfter) {
        covariance_ += Eigen::Matrix2d::Identity() * std::pow(kLost_rad * rangeOf(state_), 2);
        far_off_ = 0;
      }
      return false;
    }
    far_off_ = 0;
    // What is within the gate but unlikely pulls no more than this.
    constexpr double kLimitSigmas = 2.0;
    const double limit = kLimitSigmas * std::sqrt(S);
    const Eigen::Vector2d K = covariance_ * H.transpose() / S;
    state_.head<2>() += K * std::clamp(innovation, -limit, limit);
    covariance_ -= (K * S * K.transpose()).eval();
    return true;
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
  int far_off_ = 0;  ///< sights in a row
};

/// A stretch of sights that are far off one after the other is a slip, not a row of outliers: takes
/// the marks off such stretches.
void keepStretches(std::vector<bool>& is_plausible) {
  constexpr std::size_t kShortest = 4;
  std::size_t begin = 0;
  while (begin < is_plausible.size()) {
    const auto first = is_plausible.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto last = std::find(first, is_plausible.end(), !*first);
    if (!*first && static_cast<std::size_t>(last - first) >= kShortest)
      std::fill(first, last, true);
    begin = static_cast<std::size_t>(last - is_plausible.begin());
  }
}

}  // namespace

Eigen::Matrix2d lightNoise(const OdometryIncrement& motion, const Eigen::Vector2d& light_at_end) {
  Eigen::Matrix<double, 2, 3> J_light_motion;
  J_light_motion << -rotation2(-motion.start_from_end.yaw_rad), -perpendicular(light_at_end);
  return J_light_motion * motion.covariance * J_light_motion.transpose();
}

LightTrack trackLight(const std::vector<Sight>& sights, const RecordStart& start) {
  LightTrack track{std::vector<Vector5>(sights.size(), start.state),
                   std::vector<bool>(sights.size(), true)};
  const auto motionTo = [&](std::size_t i) {
    return correctMotion<kErrorCount>(sights[i].motion, start.errors).start_from_end;
  };
  LightTracker forward(start.state, start.errors);
  for (std::size_t i = start.sight + 1; i < sights.size(); ++i) {
    const Pose2 end_from_start = motionTo(i).inverse();
    forward.move(end_from_start, lightNoise(sights[i].motion, end_from_start * forward.light()));
    track.is_plausible[i] = forward.look(sights[i]);
    track.states[i] = forward.state();
  }
  LightTracker backward(start.state, start.errors);
  for (std::size_t i = start.sight; i > 0; --i) {
    const Pose2 start_from_end = motionTo(i);
    const Eigen::Matrix2d R = rotation2(start_from_end.yaw_rad);
    backward.move(start_from_end,
                  R * lightNoise(sights[i].motion, backward.light()) * R.transpose());
    track.is_plausible[i - 1] = backward.look(sights[i - 1]);
    track.states[i - 1] = backward.state();
  }
  keepStretches(track.is_plausible);
  return track;
}

}  // namespace bearing_calibration
