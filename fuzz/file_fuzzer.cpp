// Files: result.yaml, parameters in YAML, recordings in CSV. What is no such file ends in an error
// that says so; what is one is read as it was written.

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <type_traits>

#include "bearing_calibration/calibration/calibrator.h"
#include "bearing_calibration_ros/adapter_params.h"
#include "bearing_calibration_ros/calibrator_params.h"
#include "bearing_calibration_ros/detection_params.h"
#include "bearing_calibration_ros/drive_params.h"
#include "bearing_calibration_ros/parameter_files.h"
#include "bearing_calibration_ros/simulation_params.h"
#include "fuzz/byte_reader.h"
#include "fuzz/drawn_result.h"
#include "fuzz/harness.h"
#include "fuzz/result_checks.h"
#include "tools/owner/recording_csv.h"

namespace bearing_calibration::fuzz {
namespace {

namespace ros_side = bearing_calibration_ros;

constexpr std::size_t kMostText = 4096;

/// Whether `read` has read something; an error of a file must say what is wrong.
template <typename Error, typename Read>
bool readsOrSays(const Read& read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    require(*error.what() != '\0', "an error says nothing");
    return false;
  }
}

/// Some pieces of a text replaced by others, or by nothing.
std::string edited(std::string text, ByteReader* bytes) {
  constexpr int kMostEdits = 8;
  static constexpr const char* kPieces[] = {"",     "-",  "0",    "1e999",  ".nan",
                                            ".inf", "'",  "\"",   "[",      "]",
                                            "{",    "}",  ": ",   "\n",     "&a ",
                                            "*a",   "!",  "#",    "deg(9)", "\t",
                                            ",",    "\r", "null", "true",   "99999999999999999999"};
  for (int i = 0; i < kMostEdits && !bytes->isEmpty() && !text.empty(); ++i) {
    const std::size_t at = bytes->word() % text.size();
    const std::size_t length = bytes->byte() % 32;
    const bool is_own = bytes->flag();
    const std::string piece = is_own ? bytes->text(bytes->byte() % 16) : bytes->pick(kPieces);
    text.replace(at, length, piece);
  }
  return text;
}

bool readResult(const std::string& text) {
  const core::ResultFileContent content = readBack(text);
  if (!content.calibration) return false;
  requireRoundTrip(*content.calibration);
  return true;
}

/// A shipped file, without its comments, with the simulated robot's numbers and a light where it
/// has none.
std::string shipped(const std::string& name) {
  static ros_side::ParameterMap robot =
      ros_side::parametersFromFiles({BEARING_CALIBRATION_CONFIG_FOLDER "/robots/simulated.yaml"});
  std::ifstream file(BEARING_CALIBRATION_CONFIG_FOLDER "/" + name);
  std::string text, group;
  for (std::string line; std::getline(file, line);) {
    line.resize(std::min(line.size(), line.find('#')));
    const std::size_t colon = line.find(": required");
    if (!line.empty() && line.front() != ' ') group = line.substr(0, line.find(':'));
    if (colon != std::string::npos) {
      const std::string parameter = group + "/" + line.substr(2, colon - 2);
      std::ostringstream number;
      robot.at(parameter).write(number);
      line.replace(colon, std::string::npos, ": " + number.str());
    }
    const std::size_t list = line.find("lights: []");
    if (list != std::string::npos) {
      line.replace(list, std::string::npos, "lights: [[1, 1.0, 0.2, 0.1]]");
    }
    text += line + "\n";
  }
  return text;
}

/// A node's configuration out of a file, on top of `others`; what it accepts has no errors, and can
/// be written beside a result.
template <typename Config>
bool readNode(ros_side::ParameterMap others, const std::string& text, ByteReader* bytes) {
  Config config;
  std::map<std::string, std::string> texts;
  const bool is_read = readsOrSays<std::runtime_error>([&] {
    for (const auto& [name, value] : ros_side::parametersFromYaml(edited(text, bytes), "a file")) {
      others[name] = value;
    }
    ros_side::ParamReader params(others);
    config.declare(params);
    params.throwIfAnyError();
    texts = params.texts();
  });
  if (!is_read) return false;
  require(core::errorsOf(config).empty(), "a configuration with errors is read");
  if constexpr (std::is_same_v<Config, ros_side::CalibrationNodeConfig>) {
    core::Calibrator calibrator(config.calibrator);
  }
  core::SavedCalibration saved = drawResult(bytes);
  saved.provenance.parameters = texts;
  requireRoundTrip(saved);
  return true;
}

/// A program's parameters: a shipped file, another file over it, and one value over both.
void overlay(ByteReader* bytes) {
  const std::string text = bytes->flag() ? bytes->text(bytes->byte()) : std::string();
  const std::string assignment = text.c_str();  // a command line ends with the first zero
  const TemporaryFile robot(edited(shipped("robots/simulated.yaml"), bytes));
  ros_side::ParameterFiles files;
  files.addNode("calibration", BEARING_CALIBRATION_CONFIG_FOLDER "/calibration.yaml");
  files.overlay(robot.path());
  if (!assignment.empty()) files.set(assignment);
  ros_side::CalibrationNodeConfig config;
  ros_side::ParamReader params = files.reader("calibration");
  config.declare(params);
  params.throwIfAnyError();
  require(core::errorsOf(config).empty(), "a configuration with errors is read");
}

bool readParameters(ByteReader* bytes) {
  static const std::string calibration = shipped("calibration.yaml");
  static const std::string detection = shipped("detection.yaml");
  static const std::string drive = shipped("drive.yaml");
  static const std::string adapter = shipped("adapter.yaml");
  constexpr int kKinds = 5;
  switch (bytes->byte() % kKinds) {
    case 0:
      return readNode<ros_side::DetectionNodeConfig>({}, detection, bytes);
    case 1:
      return readNode<ros_side::DriveNodeConfig>(
          ros_side::parametersFromYaml(calibration, "a file"), drive, bytes);
    case 2:
      return readsOrSays<std::runtime_error>([bytes] { overlay(bytes); });
    case 3:
      return readNode<ros_side::CalibrationNodeConfig>({}, calibration, bytes);
    default:
      return readNode<ros_side::AdapterNodeConfig>({}, adapter, bytes);
  }
}

bool readWheels(const std::string& text) {
  return readsOrSays<core::RecordingError>([&] {
    std::istringstream stream(text);
    core::Stamp last;
    for (const core::CounterRow& row : core::readCounters(stream, "a file", {1e-4, 0.0})) {
      require(core::isStamped(row.stamp) && row.stamp > last, "stamps do not grow");
      last = row.stamp;
    }
    require(last > core::Stamp() && text.find('\0') == std::string::npos, "a broken file is read");
  });
}

bool readBearings(const std::string& text) {
  return readsOrSays<core::RecordingError>([&] {
    std::istringstream stream(text);
    core::Stamp last;
    for (const core::ObservationRow& row : core::readObservations(stream, "a file", 1, {})) {
      require(core::isStamped(row.stamp) && row.stamp >= last, "stamps go back");
      require(std::abs(row.bearing_rad) <= 2.0 * core::kPi, "a bearing is no angle");
      last = row.stamp;
    }
    require(last > core::Stamp() && text.find('\0') == std::string::npos, "a broken file is read");
  });
}

}  // namespace

bool run(const std::uint8_t* data, std::size_t size) {
  ByteReader bytes(data, size);
  switch (bytes.byte() % 6) {
    case 0: {
      const core::SavedCalibration saved = drawResult(&bytes);
      requireRoundTrip(saved);
      return readResult(edited(core::resultText(saved), &bytes));
    }
    case 1:
      return readResult(bytes.text(kMostText));
    case 2:
      return readParameters(&bytes);
    case 3:
      return readsOrSays<std::runtime_error>(
          [&] { ros_side::parametersFromYaml(bytes.text(kMostText), "a file"); });
    case 4:
      return readWheels(bytes.text(kMostText));
    default:
      return readBearings(bytes.text(kMostText));
  }
}

}  // namespace bearing_calibration::fuzz
