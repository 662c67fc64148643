#include "bearing_calibration_ros/result_messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration/output/quality.h"
#include "bearing_calibration/planning/motion_planner.h"
#include "bearing_calibration_ros/conversions.h"

namespace bearing_calibration_ros {
namespace {

using diagnostic_msgs::DiagnosticStatus;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Of light and mount with the errors of clock and wheels, in the message's order.
constexpr int kWithWheels = 5 + core::kWheelErrors;
constexpr std::array<int, kWithWheels> kPlacesWithWheels = {7, 8, 0, 1, 2, 3, 4, 5, 6};
using MatrixWithWheels = Eigen::Matrix<double, kWithWheels, kWithWheels, Eigen::RowMajor>;

void fillMount(const core::CalibrationResult& result, msg::CalibrationEstimate* message) {
  const core::MountEstimate none{Eigen::Vector3d::Constant(kNone),
                                 Eigen::Matrix3d::Constant(kNone)};
  const core::MountEstimate mount = result.base_from_sensor.value_or(none);
  message->x_m = mount.mean.x();
  message->y_m = mount.mean.y();
  message->yaw_rad = mount.mean.z();
  message->x_stddev_m = std::sqrt(mount.covariance(0, 0));
  message->y_stddev_m = std::sqrt(mount.covariance(1, 1));
  message->yaw_stddev_rad = std::sqrt(mount.covariance(2, 2));
  fillRowMajor(mount.covariance, &message->covariance_x_y_yaw);
}

void fillPaperState(const core::CalibrationResult& result, msg::CalibrationEstimate* message) {
  const core::PaperEstimate none{core::Vector5::Constant(kNone), core::Matrix5::Constant(kNone),
                                 false};
  const core::PaperEstimate paper = result.paper_state.value_or(none);
  message->D_m = paper.mean(core::PaperIndex::kDistance);
  message->theta_rad = paper.mean(core::PaperIndex::kTheta);
  message->phi_rad = paper.mean(core::PaperIndex::kPhi);
  message->rho_m = paper.mean(core::PaperIndex::kRho);
  message->psi_rad = paper.mean(core::PaperIndex::kPsi);
  message->phi_psi_determined = paper.phi_psi_determined;
  fillRowMajor(paper.covariance, &message->covariance_D_theta_phi_rho_psi);
}

/// The robot's errors, then the levels of the noise.
void fillRobotErrors(const core::CalibrationResult& result, msg::CalibrationEstimate* message) {
  MatrixWithWheels covariance = MatrixWithWheels::Constant(kNone);
  if (result.estimate) {
    const core::StateEstimate part = core::partOf(*result.estimate, core::kWheelErrors, {0});
    covariance = core::withoutNearness(part, result.error_priors.nearness_stddev_m)
                     .covariance(kPlacesWithWheels, kPlacesWithWheels);
  }
  fillRowMajor(covariance, &message->covariance_with_clock_and_wheels);
  for (const core::BlockReport& report : core::reportErrors(result)) {
    if (report.status == core::BlockStatus::kOff) continue;
    for (const core::ReportedNumber& number : report.numbers) {
      msg::RobotError error;
      error.name = number.quantity.name;
      error.value = number.value;
      error.stddev = number.stddev;
      error.unit = number.quantity.unit;
      // one that is known exactly is not estimated, whatever the others of its block are
      error.state = number.stddev > 0.0 ? static_cast<std::uint8_t>(report.status)
                                        : +msg::RobotError::HELD_AT_PRIOR;
      message->robot_errors.push_back(error);
    }
  }
}

/// The errors of clock and wheels, by their names; zero where one is not looked for.
Eigen::Matrix<double, core::kWheelErrors, 1> wheelErrorsFrom(
    const std::vector<msg::RobotError>& errors) {
  Eigen::Matrix<double, core::kWheelErrors, 1> values;
  for (int i = 0; i < core::kWheelErrors; ++i) {
    const char* name = core::errorQuantities()[static_cast<std::size_t>(i)].name;
    const auto error = std::find_if(errors.begin(), errors.end(),
                                    [name](const auto& each) { return each.name == name; });
    values(i) = error == errors.end() ? 0.0 : error->value;
  }
  return values;
}

Eigen::Vector2d lightOf(const std::optional<core::CartesianEstimate>& estimate) {
  return estimate ? estimate->lightInBase() : Eigen::Vector2d::Constant(kNone).eval();
}

msg::CalibrationLight messageFromLight(const core::LightSummary& light) {
  msg::CalibrationLight message;
  message.light_id = light.light_id;
  const auto& estimate = light.cartesian_state;
  message.x_m = lightOf(estimate).x();
  message.y_m = lightOf(estimate).y();
  const Eigen::Matrix2d covariance = estimate ? estimate->covariance.topLeftCorner<2, 2>().eval()
                                              : Eigen::Matrix2d::Constant(kNone);
  fillRowMajor(covariance, &message.covariance_x_y);
  message.in_estimate = light.in_estimate;
  message.bearings_used = light.bearings_used;
  message.note = light.note;
  return message;
}

}  // namespace

std::string rejectionsText(const core::CalibrationResult& result,
                           std::uint32_t joint_states_without_wheels) {
  std::vector<std::string> reasons;
  const auto add = [&reasons](const std::string& reason, std::uint32_t count) {
    if (count > 0) reasons.push_back(reason + ": " + std::to_string(count));
  };
  for (const auto& [stream, counts] :
       {std::pair("ticks ", &result.tick_inputs), std::pair("bearings ", &result.bearing_inputs)}) {
    for (std::size_t i = 0; i < core::kInputStatusCount; ++i) {
      const auto status = static_cast<core::InputStatus>(i);
      if (!core::InputOutcome{status, 0.0}.isWorthAWord()) continue;
      add(std::string(stream) + core::nameOf(status), (*counts)[status]);
    }
  }
  add("joint states without the wheels", joint_states_without_wheels);
  return core::joined(reasons, "; ");
}

msg::CalibrationEstimate messageFromResult(const core::CalibrationResult& result,
                                           std::uint32_t joint_states_without_wheels,
                                           const std::string& base_frame) {
  msg::CalibrationEstimate message;
  message.header.stamp = rosFromStamp(result.stamp);
  message.header.frame_id = base_frame;
  message.state = static_cast<std::uint8_t>(result.state);
  message.state_text = core::nameOf(result.state);
  message.advice = result.advice;
  message.cause = static_cast<std::uint8_t>(result.cause);
  if (result.cause != core::Fault::kNone) message.cause_text = core::nameOf(result.cause);
  fillMount(result, &message);
  message.quality = core::qualityInWords(result);
  message.light_x_m = lightOf(result.cartesian_state).x();
  message.light_y_m = lightOf(result.cartesian_state).y();
  fillPaperState(result, &message);
  fillRobotErrors(result, &message);
  if (result.lights.size() > 1) {
    for (const core::LightSummary& light : result.lights) {
      message.lights.push_back(messageFromLight(light));
    }
  }
  message.nis_mean = result.nis_mean;
  message.distance_travelled_m = result.distance_travelled_m;
  message.rotation_travelled_rad = result.rotation_travelled_rad;
  message.bearings_used = result.bearings_used;
  message.bearings_gated = result.bearings_gated;
  message.bearings_waiting = result.bearings_waiting;
  message.bearings_rejected = result.bearing_inputs.badInputs();
  message.ticks_used = result.ticks_used;
  message.ticks_rejected = result.tick_inputs.badInputs() + joint_states_without_wheels;
  message.rejections = rejectionsText(result, joint_states_without_wheels);
  return message;
}

std::optional<core::StateEstimate> robotFromMessage(const msg::CalibrationEstimate& message) {
  core::StateEstimate estimate = core::StateEstimate::zero({core::kWheelErrors, 1});
  estimate.mean << message.x_m, message.y_m, message.yaw_rad, wheelErrorsFrom(message.robot_errors),
      message.light_x_m, message.light_y_m;
  estimate.covariance(kPlacesWithWheels, kPlacesWithWheels) =
      Eigen::Map<const MatrixWithWheels>(message.covariance_with_clock_and_wheels.data());
  if (!estimate.mean.allFinite() || !estimate.covariance.allFinite()) return std::nullopt;
  for (const msg::CalibrationLight& light : message.lights) {
    const Eigen::Vector2d place_m(light.x_m, light.y_m);
    const Eigen::Matrix2d covariance(light.covariance_x_y.data());
    const bool is_the_first = light.x_m == message.light_x_m && light.y_m == message.light_y_m;
    if (is_the_first || !place_m.allFinite() || !covariance.allFinite()) continue;
    if (estimate.layout.lights < core::kMostLights) {
      estimate = core::withLight(estimate, place_m, covariance);
    }
  }
  return estimate;
}

void fillDiagnostics(const core::CalibrationResult& result,
                     std::uint32_t joint_states_without_wheels, const std::string& silence,
                     bool remarks_since_last, diagnostic_updater::DiagnosticStatusWrapper* status) {
  const std::string rejections = rejectionsText(result, joint_states_without_wheels);
  status->summary(DiagnosticStatus::OK,
                  std::string(core::nameOf(result.state)) + ": " + result.advice);
  if (result.state == core::CalibrationState::kInconsistent) {
    status->mergeSummary(DiagnosticStatus::ERROR, "do not use the result");
  }
  if (result.state == core::CalibrationState::kDegenerateMotion) {
    status->mergeSummary(DiagnosticStatus::WARN, "the motion does not determine the mount");
  }
  if (!silence.empty()) status->mergeSummary(DiagnosticStatus::WARN, silence);
  if (remarks_since_last) {
    status->mergeSummary(DiagnosticStatus::WARN, "inputs are refused or changed");
  }

  if (result.base_from_sensor) {
    const Eigen::Vector3d& mean = result.base_from_sensor->mean;
    const Eigen::Vector3d stddev = result.base_from_sensor->covariance.diagonal().cwiseSqrt();
    status->addf("x [m]", "%.4f +- %.4f", mean.x(), stddev.x());
    status->addf("y [m]", "%.4f +- %.4f", mean.y(), stddev.y());
    status->addf("yaw [deg]", "%.3f +- %.3f", core::degreesFromRadians(mean.z()),
                 core::degreesFromRadians(stddev.z()));
  }
  status->addf("NIS, running mean (1 is consistent)", "%.3f", result.nis_mean);
  status->addf("distance travelled [m]", "%.2f", result.distance_travelled_m);
  status->addf("rotation travelled [deg]", "%.0f",
               core::degreesFromRadians(result.rotation_travelled_rad));
  status->add("bearings used", result.bearings_used);
  status->add("bearings gated", result.bearings_gated);
  status->add("bearings waiting for ticks", result.bearings_waiting);
  status->add("wheel readings used", result.ticks_used);
  status->add("inputs refused", rejections.empty() ? "none" : rejections);
}

}  // namespace bearing_calibration_ros
