#include "bearing_calibration/simulation/trajectory.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace bearing_calibration::core {
namespace {

WheelDisplacement wheelsFromMotion(double distance_m, double turn_rad, double wheel_separation_m) {
  return {distance_m - 0.5 * wheel_separation_m * turn_rad,
          distance_m + 0.5 * wheel_separation_m * turn_rad};
}

}  // namespace

SegmentTrajectory::SegmentTrajectory(std::vector<DriveSegment> segments)
    : segments_(std::move(segments)) {
  if (segments_.empty()) throw std::invalid_argument("a trajectory needs at least one segment");
  for (const DriveSegment& segment : segments_) {
    if (!(segment.duration_s > 0.0)) throw std::invalid_argument("a segment must last some time");
  }
  left_in_segment_s_ = segments_.front().duration_s;
}

WheelDisplacement SegmentTrajectory::advance(double step_s) {
  WheelDisplacement wheels;
  while (step_s > 0.0) {
    const DriveSegment& segment = segments_[current_];
    const double time_s = std::min(step_s, left_in_segment_s_);
    wheels.left_m += segment.left_mps * time_s;
    wheels.right_m += segment.right_mps * time_s;
    step_s -= time_s;
    left_in_segment_s_ -= time_s;
    if (left_in_segment_s_ <= 0.0) {
      current_ = (current_ + 1) % segments_.size();
      left_in_segment_s_ = segments_[current_].duration_s;
    }
  }
  return wheels;
}

SinusoidTrajectory::SinusoidTrajectory(const Config& config, double wheel_separation_m)
    : config_(config), wheel_separation_m_(wheel_separation_m) {
  if (!(config.period_s > 0.0)) throw std::invalid_argument("a sinusoid needs a period > 0");
}

WheelDisplacement SinusoidTrajectory::advance(double step_s) {
  const auto heading = [this](double time_s) {
    return config_.amplitude_rad * std::sin(2.0 * kPi * time_s / config_.period_s);
  };
  const double turn = heading(time_s_ + step_s) - heading(time_s_);
  time_s_ += step_s;
  return wheelsFromMotion(config_.speed_mps * step_s, turn, wheel_separation_m_);
}

RandomTrajectory::RandomTrajectory(double wheel_speed_mps, double variance_per_meter_m,
                                   std::uint64_t seed)
    : wheel_speed_mps_(wheel_speed_mps),
      variance_per_meter_m_(variance_per_meter_m),
      random_(seed, RandomStream::Purpose::kTrajectory) {}

WheelDisplacement RandomTrajectory::advance(double step_s) {
  const double mean_m = wheel_speed_mps_ * step_s;
  const double stddev_m = std::sqrt(variance_per_meter_m_ * std::abs(mean_m));
  const double left_m = mean_m + stddev_m * random_.gaussian();
  return {left_m, mean_m + stddev_m * random_.gaussian()};
}

CommandedTrajectory::CommandedTrajectory(double wheel_separation_m, double max_wheel_speed_mps,
                                         double timeout_s)
    : wheel_separation_m_(wheel_separation_m),
      max_wheel_speed_mps_(max_wheel_speed_mps),
      timeout_s_(timeout_s) {}

void CommandedTrajectory::command(double forward_mps, double turn_radps) {
  if (!std::isfinite(forward_mps) || !std::isfinite(turn_radps)) {
    throw std::invalid_argument("a velocity command must be finite");
  }
  const WheelDisplacement speed = wheelsFromMotion(forward_mps, turn_radps, wheel_separation_m_);
  const double fastest = std::max(std::abs(speed.left_m), std::abs(speed.right_m));
  const double factor = fastest > max_wheel_speed_mps_ ? max_wheel_speed_mps_ / fastest : 1.0;
  command_ = {factor * speed.left_m, factor * speed.right_m, timeout_s_};
}

WheelDisplacement CommandedTrajectory::advance(double step_s) {
  const double time_s = std::min(step_s, command_.duration_s);
  command_.duration_s -= time_s;
  return {command_.left_mps * time_s, command_.right_mps * time_s};
}

LimitedTrajectory::LimitedTrajectory(std::unique_ptr<Trajectory> trajectory, double duration_s)
    : trajectory_(std::move(trajectory)), left_s_(duration_s) {
  if (!trajectory_) throw std::invalid_argument("a limited trajectory needs one to limit");
}

WheelDisplacement LimitedTrajectory::advance(double step_s) {
  const double time_s = std::min(step_s, left_s_);
  left_s_ -= time_s;
  return time_s > 0.0 ? trajectory_->advance(time_s) : WheelDisplacement{};
}

}  // namespace bearing_calibration::core
