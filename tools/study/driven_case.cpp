#include "tools/study/driven_case.h"

#include <time.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration/odometry/wheel_odometer.h"
#include "tools/study/monte_carlo_trials.h"

namespace bearing_calibration::core {
namespace {

constexpr double kCommandTimeout_s = 0.5;
constexpr double kSteeringPeriod_s = 0.05;

/// Of this thread: a machine that is busy with other things does not make a decision longer.
double processorMilliseconds() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

/// Robot, calibration and driver around one table.
class Loop {
 public:
  explicit Loop(const DrivenCase& driven)
      : driven_(driven),
        calibrator_(calibratorConfig(driven.simulated)),
        odometer_(driven.simulated.robot.encoders.drive),
        driver_(driven.drive, driven.goal, driven.simulated.robot.start),
        commanded_(driven.simulated.robot.encoders.drive.wheel_separation_m,
                   driven.simulated.robot.encoders.drive.max_wheel_speed_mps, kCommandTimeout_s),
        simulator_(driven.simulated.robot, driven.simulated.lights,
                   [this](double step_s) { return commanded_.advance(step_s); }) {
    record_.least_distance_m = std::numeric_limits<double>::infinity();
    record_.least_kept_distance_m = std::numeric_limits<double>::infinity();
    record_.first_estimate_s = std::numeric_limits<double>::infinity();
  }

  DriveRecord run() {
    while (driver_.ended() == DriveEnd::kNone || !driver_.standing()) {
      sense();
      if (simulator_.now() >= next_steering_) steer();
      simulator_.step();
    }
    record_.end = driver_.ended();
    record_.time_s = driver_.timeSeconds();
    record_.path_m = driver_.pathMeters();
    return record_;
  }

 private:
  void sense() {
    const Stamp now = simulator_.now();
    if (const auto ticks = simulator_.readTicks()) {
      calibrator_.addTicks(*ticks, now);
      odometer_.add(*ticks);
      driver_.addTravel(*odometer_.travel(), now);
    }
    const auto bearings = inView(look());
    if (bearings) {
      const BearingSet told = toldOf(driven_.simulated, *bearings);
      calibrator_.addBearings(told, now);
      driver_.addBearings(told, now);
      ++record_.images;
      if (!bearings->candidates.empty()) ++record_.images_with_light;
      tell(now);
    }
    const double distance_m = lightInBase().norm();
    record_.least_distance_m = std::min(record_.least_distance_m, distance_m);
    is_kept_ = is_kept_ || (record_.result.cartesian_state && distance_m >= kNear_m);
    if (is_kept_) {
      record_.least_kept_distance_m = std::min(record_.least_kept_distance_m, distance_m);
    }
  }

  std::optional<BearingSet> look() {
    if (!driven_.look) return simulator_.readBearings();
    if (!simulator_.bearingsDue()) return std::nullopt;
    return driven_.look(simulator_);
  }

  /// What of it the sensor sees.
  std::optional<BearingSet> inView(std::optional<BearingSet> bearings) const {
    if (!bearings) return bearings;
    std::vector<Bearing>& candidates = bearings->candidates;
    const auto isOutside = [this](const Bearing& bearing) {
      return driven_.view.chanceOf(bearing.azimuth_rad, 0.0) == 0.0;
    };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), isOutside),
                     candidates.end());
    if (driven_.is_view_known) bearings->view = driven_.view;
    return bearings;
  }

  void tell(Stamp now) {
    const CalibrationResult result = calibrator_.result();
    DriveEstimate estimate{result.stamp, result.state, {}, result.error_priors.nearness_stddev_m};
    if (result.estimate) {
      estimate.robot =
          withoutNearness(partOf(*result.estimate, kWheelErrors, {0}), estimate.nearness_stddev_m);
    }
    if (!driven_.stops_when_converged && estimate.state == CalibrationState::kConverged) {
      estimate.state = CalibrationState::kConverging;
    }
    driver_.addEstimate(estimate, now);
    if (estimate.robot) {
      record_.first_estimate_s = std::min(record_.first_estimate_s, driver_.timeSeconds());
    }
    if (driver_.ended() != DriveEnd::kNone && record_.result.bearings_used > 0) return;
    record_.result = result;
    record_.truth << lightInBase(), driven_.simulated.robot.base_from_sensor.position_m,
        driven_.simulated.robot.base_from_sensor.yaw_rad;
  }

  void steer() {
    next_steering_ = simulator_.now() + durationFromSeconds(kSteeringPeriod_s);
    const double before_ms = processorMilliseconds();
    const WheelSpeeds speeds = driver_.steer(simulator_.now());
    record_.worst_decision_ms =
        std::max(record_.worst_decision_ms, processorMilliseconds() - before_ms);
    const double separation_m = driven_.drive.limits.wheel_separation_m;
    commanded_.command(0.5 * (speeds.left_mps + speeds.right_mps),
                       (speeds.right_mps - speeds.left_mps) / separation_m);
  }

  Eigen::Vector2d lightInBase() const {
    return simulator_.worldFromBase().inverse() * simulator_.lights().front().position_m;
  }

  const DrivenCase& driven_;
  Calibrator calibrator_;
  WheelOdometer odometer_;
  CalibrationDriver driver_;
  CommandedTrajectory commanded_;
  RobotSimulator simulator_;
  Stamp next_steering_;
  bool is_kept_ = false;
  DriveRecord record_;
};

}  // namespace

DriveConfig paperDrive() {
  DriveConfig drive;
  drive.limits = {0.25, 0.2, 1.0};
  drive.sensing = {{1e-6, 0.0}, radiansFromDegrees(1.0), 10.0};
  drive.planner = {PlannerConfig::Block::kMount, 0.5, 2.0, 0.1, 1.0};
  drive.region.radius_m = 4.0;
  drive.timeouts = {0.5, 3.0, 3.0};
  return drive;
}

DriveRecord drive(const DrivenCase& driven) { return Loop(driven).run(); }

double polarFigure(const Eigen::Matrix3d& mount_covariance, double rho_m) {
  constexpr double kMillimeters = 1000.0;
  const double determinant_of_change = kDegreesPerRadian * kMillimeters * kDegreesPerRadian /
                                       rho_m;  // d(phi, rho, psi)/d(x, y, yaw)
  return std::pow(mount_covariance.determinant(), 1.0 / 6.0) * std::cbrt(determinant_of_change);
}

}  // namespace bearing_calibration::core
