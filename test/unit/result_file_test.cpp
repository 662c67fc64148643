#include "bearing_calibration/output/result_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "support/temporary_folder.h"

namespace bearing_calibration::core {
namespace {

namespace fs = std::filesystem;

/// A folder of its own for each test, removed at the end.
class ResultFileTest : public testing::Test {
 protected:
  std::string text() const {
    std::ostringstream text;
    text << std::ifstream(path_).rdbuf();
    return text.str();
  }
  void writeText(const std::string& text) const { std::ofstream(path_) << text; }

  const TemporaryFolder own_;
  const fs::path folder_ = own_.path();
  const std::string path_ = folder_ / "result.yaml";
};

/// Positive definite, with entries that have no short decimal form.
template <int Size>
Eigen::Matrix<double, Size, Size> someCovariance() {
  Eigen::Matrix<double, Size, Size> root;
  for (int i = 0; i < Size * Size; ++i) root(i) = std::sin(i + 1.0) / 3.0;
  Eigen::Matrix<double, Size, Size> covariance = root * root.transpose();
  covariance.diagonal().array() += 1e-3;
  return covariance;
}

SavedCalibration someCalibration() {
  SavedCalibration saved;
  CalibrationResult& result = saved.result;
  result.state = CalibrationState::kConverging;
  result.advice = "turn on the spot: \"x\" is weak\nand # so on";
  result.stamp = stampFromNanoseconds(1700000000123456789);
  saved.base_frame = "base_link";
  saved.sensor_frame = "camera";
  result.base_from_sensor = {{1.0 / 3.0, -0.1, -2.0 / 7.0}, someCovariance<3>()};
  saved.unestimated = {0.35, 0.01, -0.001, 0.02, 1e-5, 0.03};
  result.paper_state.emplace().mean << 2.0, 0.1, -0.3, 0.34, 1e-17;
  result.paper_state->covariance = someCovariance<5>();
  result.paper_state->phi_psi_determined = true;
  result.cartesian_state.emplace().mean << 2.0, -1.0, 0.33, -0.1, -0.28;
  result.cartesian_state->covariance = 2.0 * someCovariance<5>();
  saved.lasting = lastingPart(saved.mount());
  constexpr int kSeparation = kMountSize + placeOf<WheelSeparation>();
  saved.lasting.mean(kSeparation) = 1e-3;
  saved.lasting.covariance(kSeparation, kSeparation) = 4e-4;
  saved.lasting.covariance(0, kSeparation) = saved.lasting.covariance(kSeparation, 0) = 1e-4;
  result.nis_mean = 1.02;
  result.distance_travelled_m = 12.5;
  result.rotation_travelled_rad = 33.1;
  result.bearings_used = 4000000000U;
  result.bearings_gated = 7;
  result.ticks_used = 4000000001U;
  saved.rejections = "bearings no stamp: 3";
  saved.provenance = {"a test",
                      "2026-01-01T00:00:00Z",
                      "a.bag",
                      {0.25, 0.03, 0.031, 2048.0, 16, 1.5},
                      {{"bearing_calibration", "\"0.1.0\""}},
                      {{"frames/base", "\"no\""},
                       {"mask/posts", "[[0.5, 0.1], [1, 0.25]]"},
                       {"wheels/separation", "0.25"}}};
  return saved;
}

TEST_F(ResultFileTest, ReadsBackExactlyWhatWasWritten) {
  const SavedCalibration saved = someCalibration();
  writeText(resultText(saved));
  const ResultFileContent content = readResultFile(path_);
  ASSERT_TRUE(content.calibration.has_value()) << content.error;
  const SavedCalibration& read = *content.calibration;
  EXPECT_EQ(read.result.state, saved.result.state);
  EXPECT_EQ(read.result.advice, saved.result.advice);
  EXPECT_EQ(read.result.stamp, saved.result.stamp);
  EXPECT_EQ(read.base_frame, saved.base_frame);
  EXPECT_EQ(read.sensor_frame, saved.sensor_frame);
  EXPECT_EQ(read.mount().mean, saved.mount().mean);
  EXPECT_EQ(read.mount().covariance, saved.mount().covariance);
  EXPECT_EQ(read.unestimated.z_m, saved.unestimated.z_m);
  EXPECT_EQ(read.unestimated.z_stddev_m, saved.unestimated.z_stddev_m);
  EXPECT_EQ(read.unestimated.roll_rad, saved.unestimated.roll_rad);
  EXPECT_EQ(read.unestimated.roll_stddev_rad, saved.unestimated.roll_stddev_rad);
  EXPECT_EQ(read.unestimated.pitch_rad, saved.unestimated.pitch_rad);
  EXPECT_EQ(read.unestimated.pitch_stddev_rad, saved.unestimated.pitch_stddev_rad);
  EXPECT_EQ(read.result.paper_state->mean, saved.result.paper_state->mean);
  EXPECT_EQ(read.result.paper_state->covariance, saved.result.paper_state->covariance);
  EXPECT_EQ(read.result.paper_state->phi_psi_determined,
            saved.result.paper_state->phi_psi_determined);
  EXPECT_EQ(read.result.cartesian_state->mean, saved.result.cartesian_state->mean);
  EXPECT_EQ(read.result.cartesian_state->covariance, saved.result.cartesian_state->covariance);
  EXPECT_EQ(read.lasting.mean, saved.lasting.mean);
  EXPECT_EQ(read.lasting.covariance, saved.lasting.covariance);
  EXPECT_EQ(read.result.nis_mean, saved.result.nis_mean);
  EXPECT_EQ(read.result.distance_travelled_m, saved.result.distance_travelled_m);
  EXPECT_EQ(read.result.rotation_travelled_rad, saved.result.rotation_travelled_rad);
  EXPECT_EQ(read.result.bearings_used, saved.result.bearings_used);
  EXPECT_EQ(read.result.bearings_gated, saved.result.bearings_gated);
  EXPECT_EQ(read.result.ticks_used, saved.result.ticks_used);
  EXPECT_EQ(read.rejections, saved.rejections);
  EXPECT_EQ(read.provenance.source, saved.provenance.source);
  EXPECT_EQ(read.provenance.program, saved.provenance.program);
  EXPECT_EQ(read.provenance.written_at, saved.provenance.written_at);
  EXPECT_EQ(read.provenance.drive.wheel_separation_m, 0.25);
  EXPECT_EQ(read.provenance.drive.left_wheel_radius_m, 0.03);
  EXPECT_EQ(read.provenance.drive.right_wheel_radius_m, 0.031);
  EXPECT_EQ(read.provenance.drive.ticks_per_revolution, 2048.0);
  EXPECT_EQ(read.provenance.drive.counter_bits, 16);
  EXPECT_EQ(read.provenance.drive.max_wheel_speed_mps, 1.5);
}

// For programs in any language: plain keys, matrices as rows, values that keep their kind.
TEST_F(ResultFileTest, IsPlainYaml) {
  SavedCalibration saved = someCalibration();
  saved.result.error_priors.setBlock(WheelSeparation::kName, 0.01);
  saved.result.robot_errors = priorEstimate(saved.result.error_priors);
  saved.result.robot_errors.mean(placeOf<WheelSeparation>()) = 0.02;
  const CartesianEstimate& estimate = *saved.result.cartesian_state;
  saved.result.lights.resize(2);
  saved.result.lights[0].light_id = 7;
  saved.result.lights[0].cartesian_state = estimate;
  saved.result.lights[0].in_estimate = true;
  saved.result.lights[1].note = "not found yet";
  writeText(resultText(saved));
  const YAML::Node root = YAML::LoadFile(path_);
  EXPECT_EQ(root["state"].as<std::string>(), "CONVERGING");
  EXPECT_EQ(root["base_from_camera"]["yaw"].as<double>(), -2.0 / 7.0);
  EXPECT_EQ(root["stddev"]["x"].as<double>(), std::sqrt(someCovariance<3>()(0, 0)));
  EXPECT_EQ(root["covariance_x_y_yaw"][2][0].as<double>(), someCovariance<3>()(2, 0));
  EXPECT_EQ(root["paper_state"]["covariance_D_theta_phi_rho_psi"][4][3].as<double>(),
            someCovariance<5>()(4, 3));
  EXPECT_EQ(root["lights"][0]["id"].as<int>(), 7);
  EXPECT_EQ(root["lights"][0]["x_m"].as<double>(), estimate.mean(0));
  EXPECT_EQ(root["lights"][0]["covariance_x_y"][1][0].as<double>(), estimate.covariance(1, 0));
  EXPECT_TRUE(root["lights"][0]["in_estimate"].as<bool>());
  EXPECT_FALSE(root["lights"][1]["id"].IsDefined() || root["lights"][1]["x_m"].IsDefined());
  EXPECT_EQ(root["lights"][1]["note"].as<std::string>(), "not found yet");
  const YAML::Node separation = root["blocks"][2];
  EXPECT_EQ(separation["name"].as<std::string>(), WheelSeparation::kName);
  EXPECT_EQ(separation["status"].as<std::string>(), "held at its prior");
  EXPECT_EQ(separation["value"]["wheel_separation_scale"].as<double>(), 0.02);
  EXPECT_EQ(separation["stddev"]["wheel_separation_scale"].as<double>(), 0.01);
  EXPECT_EQ(separation["note"].as<std::string>(), WheelSeparation::kWhenHeld);
  EXPECT_EQ(root["parameters"]["frames/base"].Tag(), "!") << "a quoted string stays one";
  EXPECT_EQ(root["parameters"]["mask/posts"][1][1].as<double>(), 0.25);
  EXPECT_EQ(root["parameters"]["wheels/separation"].as<double>(), 0.25);
  EXPECT_EQ(root["versions"]["bearing_calibration"].as<std::string>(), "0.1.0");
}

TEST(ShortestText, WholeNumbersAreWhole) {
  EXPECT_EQ(shortestText(100.0), "100");
  EXPECT_EQ(shortestText(-36000.0), "-36000");
  EXPECT_EQ(shortestText(0.0), "0");
  EXPECT_EQ(shortestText(1e-6), "1.0e-06");
  EXPECT_EQ(shortestText(1e300), "1.0e+300");
  EXPECT_EQ(shortestText(0.1), "0.1");
}

TEST_F(ResultFileTest, EveryStateHasANameThatReadsBack) {
  for (int value = 0; value <= static_cast<int>(CalibrationState::kPaused); ++value) {
    SavedCalibration saved = someCalibration();
    saved.result.state = static_cast<CalibrationState>(value);
    writeText(resultText(saved));
    const ResultFileContent content = readResultFile(path_);
    ASSERT_TRUE(content.calibration.has_value()) << content.error;
    EXPECT_EQ(content.calibration->result.state, saved.result.state);
  }
}

// Whatever the place at which the file is cut, what remains is refused and nothing is thrown.
// Promise kept: a result file that is cut short anywhere; it is not resumed
TEST_F(ResultFileTest, RefusesAFileCutShortAnywhere) {
  writeText(resultText(someCalibration()));
  const std::string whole = text();
  constexpr std::size_t kStep = 7;  // characters; every kind of place is hit, in a second
  const std::string last_value = "true\n";
  ASSERT_EQ(whole.substr(whole.size() - last_value.size()), last_value);
  for (std::size_t length = 0; length + last_value.size() <= whole.size(); length += kStep) {
    writeText(whole.substr(0, length));
    const ResultFileContent content = readResultFile(path_);
    ASSERT_FALSE(content.calibration.has_value()) << "cut after " << length << " characters";
    ASSERT_NE(content.error.find(path_), std::string::npos) << content.error;
  }
}

struct Damage {
  std::string find;
  std::string replace;
  std::string said;  ///< must be in the message
};

TEST_F(ResultFileTest, RefusesWhatCannotBeAndSaysWhy) {
  writeText(resultText(someCalibration()));
  const std::string whole = text();
  const std::vector<Damage> damages = {
      {"bearing_calibration result", "camera_calibration", "not a result file"},
      {"version: 3", "version: 2", "version 2"},
      {"CONVERGING", "FINISHED", "FINISHED"},
      {"y: -0.1", "y: .nan", "'y' is not finite"},
      {"y: -0.1", "y: left", "'y' has a value of a wrong kind"},
      {"y: -0.1", "why: -0.1", "'y' is missing"},
      {"z_stddev_m: 0.01", "z_stddev_m: 0", "z_stddev"},
      {"covariance_x_y_yaw:\n  - [", "covariance_x_y_yaw:\n  - [1, ", "does not have 3x3 numbers"},
      {"covariance_x_y_yaw:\n  - [0.", "covariance_x_y_yaw:\n  - [-1.", "is not a covariance"},
      {"bearings_used: 4000000000", "bearings_used: -1", "bearings_used"},
      {"not_estimated:", "not_estimated: [", "refused"},
  };
  for (const Damage& damage : damages) {
    std::string damaged = whole;
    const std::size_t place = damaged.find(damage.find);
    ASSERT_NE(place, std::string::npos) << damage.find << " is not in\n" << whole;
    damaged.replace(place, damage.find.size(), damage.replace);
    writeText(damaged);
    const ResultFileContent content = readResultFile(path_);
    EXPECT_FALSE(content.calibration.has_value()) << damage.replace;
    EXPECT_NE(content.error.find(damage.said), std::string::npos) << content.error;
    EXPECT_NE(content.error.find(path_), std::string::npos) << content.error;
  }
}

// Promise kept: a result file with an impossible covariance; it is not resumed
TEST_F(ResultFileTest, RefusesCovariancesThatAreNone) {
  Eigen::Matrix3d asymmetric = Eigen::Matrix3d::Identity();
  asymmetric(0, 1) = 0.1;
  Eigen::Matrix3d indefinite = Eigen::Matrix3d::Identity();
  indefinite(0, 1) = indefinite(1, 0) = 2.0;  // a correlation of 2
  const Eigen::Matrix3d certain = Eigen::Vector3d(1.0, 1.0, 0.0).asDiagonal();
  for (const Eigen::Matrix3d& none : {asymmetric, indefinite, certain}) {
    SavedCalibration saved = someCalibration();
    saved.result.base_from_sensor->covariance = none;
    writeText(resultText(saved));
    const ResultFileContent content = readResultFile(path_);
    EXPECT_FALSE(content.calibration.has_value()) << none;
    EXPECT_NE(content.error.find("is not a covariance"), std::string::npos) << content.error;
  }
}

TEST_F(ResultFileTest, RefusesForeignContent) {
  for (const std::string content :
       {"", "hello", "- 1\n- 2\n",
        "\x7f"
        "ELF\x01\x02",
        "a: [b", "image_width: 640\ncamera_name: c\n", "format: [1, 2]\n"}) {
    writeText(content);
    EXPECT_FALSE(readResultFile(path_).calibration.has_value()) << content;
    EXPECT_FALSE(readResultFile(path_).error.empty()) << content;
  }
  EXPECT_NE(readResultFile((folder_ / "none.yaml").string()).error.find("cannot be read"),
            std::string::npos);
}

}  // namespace
}  // namespace bearing_calibration::core
