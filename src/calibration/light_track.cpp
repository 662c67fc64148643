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
  explicit LightTracker(const Vector5& start) : state_(start) {
    constexpr double kStddevPerRange = 0.05;  // of a start from a good fit
    const double range = (start.head<2>() - start.segment<2>(CartesianIndex::kSensorX)).norm();
    covariance_ = Eigen::Matrix2d::Identity() * std::pow(kStddevPerRange * range, 2);
  }

  void move(const Pose2& now_from_before, const Eigen::Matrix2d& noise) {
    const Eigen::Matrix2d R = rotation2(now_from_before.yaw_rad);
    state_.head<2>() = now_from_before * Eigen::Vector2d(state_.head<2>());
    covariance_ = R * covariance_ * R.transpose() + noise;
  }

  void look(const Sight& sight) {
    constexpr double kLimitSigmas = 2.0;  // an outlier pulls no more than this
    const AzimuthModel model = azimuthFromCartesian(state_);
    const Eigen::RowVector2d H = model.J_azimuth_state.head<2>();
    const double S = (H * covariance_ * H.transpose()).value() + sight.azimuth_variance_rad2;
    const Eigen::Vector2d K = covariance_ * H.transpose() / S;
    const double limit = kLimitSigmas * std::sqrt(S);
    const double innovation =
        std::clamp(wrapAngle(sight.azimuth_rad - model.azimuth_rad), -limit, limit);
    state_.head<2>() += K * innovation;
    covariance_ -= (K * S * K.transpose()).eval();
  }

  Eigen::Vector2d light() const { return state_.head<2>(); }
  const Vector5& state() const { return state_; }

 private:
  Vector5 state_;
  Eigen::Matrix2d covariance_;
};

}  // namespace

Eigen::Matrix2d lightNoise(const OdometryIncrement& motion, const Eigen::Vector2d& light_at_end) {
  Eigen::Matrix<double, 2, 3> J_light_motion;
  J_light_motion << -rotation2(-motion.start_from_end.yaw_rad), -perpendicular(light_at_end);
  return J_light_motion * motion.covariance * J_light_motion.transpose();
}

std::vector<Vector5> trackLight(const std::vector<Sight>& sights, const RecordStart& start) {
  std::vector<Vector5> states(sights.size(), start.state);
  LightTracker forward(start.state);
  for (std::size_t i = start.sight + 1; i < sights.size(); ++i) {
    const Pose2 end_from_start = sights[i].motion.start_from_end.inverse();
    forward.move(end_from_start, lightNoise(sights[i].motion, end_from_start * forward.light()));
    forward.look(sights[i]);
    states[i] = forward.state();
  }
  LightTracker backward(start.state);
  for (std::size_t i = start.sight; i > 0; --i) {
    const Pose2& start_from_end = sights[i].motion.start_from_end;
    const Eigen::Matrix2d R = rotation2(start_from_end.yaw_rad);
    backward.move(start_from_end,
                  R * lightNoise(sights[i].motion, backward.light()) * R.transpose());
    backward.look(sights[i - 1]);
    states[i - 1] = backward.state();
  }
  return states;
}

}  // namespace bearing_calibration
