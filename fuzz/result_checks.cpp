#include "fuzz/result_checks.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/symmetric.h"
#include "bearing_calibration/init/start_obstacle.h"
#include "bearing_calibration/judge/convergence_judge.h"
#include "fuzz/harness.h"

namespace bearing_calibration::fuzz {
namespace {

template <class Estimate>
void requireEstimate(const Estimate& estimate, const std::string& name) {
  require(estimate.mean.allFinite(), name + " is not finite");
  requireCovariance(estimate.covariance, name);
}

void requireMotion(const core::CalibrationResult& result) {
  if (result.state != core::CalibrationState::kConverged) return;
  require(result.distance_travelled_m > 0.0, "CONVERGED without any way");
  require(result.rotation_travelled_rad >= core::StartLimits::kMinTurn_rad,
          "CONVERGED without a turn");
  require(core::motionOf(result.distance_travelled_m, result.rotation_travelled_rad) >=
              core::kHeldOver_m,
          "CONVERGED before a metre and a turn have confirmed it");
}

/// The fields that a file is read for.
core::SavedCalibration readPart(const core::SavedCalibration& saved) {
  core::SavedCalibration part = saved;
  core::CalibrationResult& result = part.result;
  result = core::CalibrationResult();
  result.state = saved.result.state;
  result.advice = saved.result.advice;
  result.stamp = saved.result.stamp;
  result.base_from_sensor = saved.result.base_from_sensor;
  result.paper_state = saved.result.paper_state;
  result.cartesian_state = saved.result.cartesian_state;
  result.nis_mean = saved.result.nis_mean;
  result.distance_travelled_m = saved.result.distance_travelled_m;
  result.rotation_travelled_rad = saved.result.rotation_travelled_rad;
  result.bearings_used = saved.result.bearings_used;
  result.bearings_gated = saved.result.bearings_gated;
  result.ticks_used = saved.result.ticks_used;
  part.provenance.versions.clear();
  part.provenance.parameters.clear();
  return part;
}

}  // namespace

void requireCovariance(const Eigen::MatrixXd& matrix, const std::string& name) {
  constexpr double kRounding = 1e-9;  // relative; far above that of an update in doubles
  require(matrix.allFinite(), name + "'s covariance is not finite");
  const double rounding = kRounding * matrix.cwiseAbs().maxCoeff();
  require((matrix - matrix.transpose()).cwiseAbs().maxCoeff() <= rounding,
          name + "'s covariance is not symmetric");
  require(matrix.diagonal().minCoeff() >= 0.0, name + " has a negative variance");
  require(core::eigenOf(matrix).values.minCoeff() >= -rounding,
          name + "'s covariance has a negative eigenvalue");
}

void requireMeaning(const core::CalibrationResult& result) {
  require(!result.advice.empty(), "no advice");
  require(std::isfinite(result.nis) && std::isfinite(result.nis_mean) && result.nis_mean >= 0.0,
          "the NIS is no number");
  require(
      std::isfinite(result.distance_travelled_m) && std::isfinite(result.rotation_travelled_rad),
      "the motion is not finite");
  require(result.start_from_base.position_m.allFinite() &&
              std::abs(result.start_from_base.yaw_rad) <= core::kPi,
          "the place of the base is none");
  require(result.noise.bearing.value > 0.0 && std::isfinite(result.noise.bearing.value) &&
              result.noise.wheel.value > 0.0 && std::isfinite(result.noise.wheel.value),
          "a level of the noise is none");
  requireEstimate(result.robot_errors, "robot_errors");
  if (result.estimate) requireEstimate(*result.estimate, "the estimate");
  if (result.cartesian_state) requireEstimate(*result.cartesian_state, "cartesian_state");
  if (result.paper_state) requireEstimate(*result.paper_state, "paper_state");
  for (const core::LightSummary& light : result.lights) {
    if (light.cartesian_state) requireEstimate(*light.cartesian_state, "a light");
  }
  if (result.base_from_sensor) {
    requireEstimate(*result.base_from_sensor, "the mount");
    require(std::abs(result.base_from_sensor->mean.z()) <= core::kPi, "the yaw is no angle");
  }
  require(result.base_from_sensor || !core::mayBeTrusted(result.state),
          "to be trusted, without a mount");
  for (const core::BlockReport& block : core::reportErrors(result)) {
    for (const core::ReportedNumber& number : block.numbers) {
      require(std::isfinite(number.value) && number.stddev >= 0.0, block.name + " is no number");
    }
  }
  requireMotion(result);
}

TemporaryFile::TemporaryFile(const std::string& text)
    : path_(std::filesystem::temp_directory_path() / ("fuzz_" + std::to_string(::getpid()))) {
  std::ofstream(path_, std::ios::binary) << text;
}

TemporaryFile::~TemporaryFile() { std::filesystem::remove(path_); }

core::ResultFileContent readBack(const std::string& text) {
  const TemporaryFile file(text);
  core::ResultFileContent content = core::readResultFile(file.path());
  require(content.calibration.has_value() == content.error.empty(), "neither read nor refused");
  return content;
}

void requireRoundTrip(const core::SavedCalibration& saved) {
  const core::ResultFileContent content = readBack(core::resultText(saved));
  require(content.calibration.has_value(), "a written result is refused: " + content.error);
  require(core::resultText(readPart(saved)) == core::resultText(readPart(*content.calibration)),
          "a written result is read as another one");
}

}  // namespace bearing_calibration::fuzz
