#include "fuzz/drawn_result.h"

#include <cmath>
#include <string>

namespace bearing_calibration::fuzz {
namespace {

double positiveOf(ByteReader* bytes) {
  constexpr double kLeast = 1e-9;
  return kLeast + bytes->between(0.0, 1.0);
}

std::string textOf(ByteReader* bytes) {
  static constexpr const char* kCharacters[] = {"a", "\"", "\\", "\n", ": ", "#",
                                                "'", " ",  "-",  "\t", "é",  "%",
                                                "{", "[",  "&",  "0x", "~",  "\x01"};
  std::string text;
  for (int i = bytes->byte() % 8; i > 0; --i) text += bytes->pick(kCharacters);
  return text;
}

/// R R^T and something on the diagonal.
template <class Matrix>
void drawCovariance(ByteReader* bytes, Matrix* covariance) {
  Eigen::MatrixXd root(covariance->rows(), covariance->cols());
  for (Eigen::Index i = 0; i < root.size(); ++i) root(i) = bytes->between(-1.0, 1.0);
  const double size = std::pow(10.0, bytes->between(-10.0, 2.0));
  *covariance =
      size * (root * root.transpose() + 1e-3 * Eigen::MatrixXd::Identity(root.rows(), root.cols()));
}

core::LightSummary drawLight(ByteReader* bytes) {
  core::LightSummary light;
  light.light_id = static_cast<std::int32_t>(bytes->bits());
  if (bytes->flag()) {
    light.cartesian_state.emplace();
    for (double& number : light.cartesian_state->mean) number = bytes->between(-10.0, 10.0);
    drawCovariance(bytes, &light.cartesian_state->covariance);
  }
  light.in_estimate = bytes->flag();
  light.bearings_used = bytes->word();
  light.note = textOf(bytes);
  return light;
}

}  // namespace

core::SavedCalibration drawResult(ByteReader* bytes) {
  constexpr int kStates = static_cast<int>(core::CalibrationState::kPaused) + 1;
  core::SavedCalibration saved;
  core::CalibrationResult& result = saved.result;
  result.state = static_cast<core::CalibrationState>(bytes->byte() % kStates);
  result.advice = textOf(bytes);
  result.stamp = core::stampFromNanoseconds(static_cast<std::int64_t>(bytes->bits() >> 2U));
  result.estimate = core::StateEstimate::zero({core::kErrorCount, 1});
  for (double& number : result.estimate->mean) number = bytes->between(-10.0, 10.0);
  drawCovariance(bytes, &result.estimate->covariance);
  core::sayEstimate(core::StateEstimate(*result.estimate), &result);
  saved.lasting = core::lastingPart(*result.estimate);
  result.nis_mean = bytes->finiteNumber();
  result.distance_travelled_m = bytes->finiteNumber();
  result.rotation_travelled_rad = bytes->finiteNumber();
  result.bearings_used = static_cast<std::uint32_t>(bytes->bits());
  result.bearings_gated = bytes->word();
  result.ticks_used = static_cast<std::uint32_t>(bytes->bits());
  saved.base_frame = textOf(bytes);
  saved.sensor_frame = textOf(bytes);
  saved.unestimated = {0.1, positiveOf(bytes), 0.2, positiveOf(bytes), 0.3, positiveOf(bytes)};
  saved.rejections = textOf(bytes);
  saved.provenance = {textOf(bytes),
                      textOf(bytes),
                      textOf(bytes),
                      {positiveOf(bytes), positiveOf(bytes), 1.0, 2048.0, 16, 1.5},
                      {{"bearing_calibration", "\"0.1.0\""}},
                      {{"wheels/separation", "0.25"}}};
  constexpr int kMostLights = 3;
  for (int i = bytes->byte() % kMostLights; i > 0; --i) result.lights.push_back(drawLight(bytes));
  return saved;
}

}  // namespace bearing_calibration::fuzz
