#include "bearing_calibration_ros/parameter_files.h"

#include <ros/package.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "bearing_calibration/common/angle.h"
#include "bearing_calibration/common/formatted.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {
namespace {

using core::formatted;
using XmlRpc::XmlRpcValue;

std::runtime_error errorAt(const std::string& origin, const YAML::Mark& mark,
                           const std::string& what) {
  return std::runtime_error(origin + ": line " + std::to_string(mark.line + 1) + ": " + what);
}

/// A number as YAML writes it, or an angle in radians: deg(30), rad(0.5).
std::optional<double> numberFrom(const std::string& text) {
  double number = 0.0;
  int end = 0;
  const auto is = [&](const char* format) {
    return std::sscanf(text.c_str(), format, &number, &end) == 1 &&
           static_cast<std::size_t>(end) == text.size();
  };
  if (is("deg( %lf )%n")) return core::radiansFromDegrees(number);
  if (is("rad( %lf )%n")) return number;
  if (YAML::convert<double>::decode(YAML::Node(text), number)) return number;
  return std::nullopt;
}

/// The first of integer, number and boolean that a plain scalar can be; else a string.
XmlRpcValue scalarFrom(const YAML::Node& node) {
  const bool is_quoted = node.Tag() == "!";
  if (is_quoted) return XmlRpcValue(node.Scalar());
  int integer = 0;
  if (YAML::convert<int>::decode(node, integer)) return XmlRpcValue(integer);
  if (const auto number = numberFrom(node.Scalar())) return XmlRpcValue(*number);
  bool boolean = false;
  if (YAML::convert<bool>::decode(node, boolean)) return XmlRpcValue(boolean);
  return XmlRpcValue(node.Scalar());
}

/// Where the content of a parser's newest document begins.
class ContentBegin : public YAML::EventHandler {
  using Mark = YAML::Mark;
  using Anchor = YAML::anchor_t;
  using Style = YAML::EmitterStyle::value;
  using Text = std::string;

 public:
  const Mark& mark() const { return *mark_; }

  void OnDocumentStart(const Mark&) override { mark_.reset(); }
  void OnDocumentEnd() override {}
  void OnNull(const Mark& mark, Anchor) override { at(mark); }
  void OnAlias(const Mark& mark, Anchor) override { at(mark); }
  void OnScalar(const Mark& mark, const Text&, Anchor, const Text&) override { at(mark); }
  void OnSequenceStart(const Mark& mark, const Text&, Anchor, Style) override { at(mark); }
  void OnSequenceEnd() override {}
  void OnMapStart(const Mark& mark, const Text&, Anchor, Style) override { at(mark); }
  void OnMapEnd() override {}

 private:
  void at(const Mark& mark) {
    if (!mark_) mark_ = mark;
  }

  std::optional<Mark> mark_;
};

/// Instead of YAML::LoadAll(), for which "," is documents without an end.
YAML::Node onlyDocument(const std::string& text, const std::string& origin) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  ContentBegin begin;
  if (parser.HandleNextDocument(begin) && parser.HandleNextDocument(begin)) {
    throw errorAt(origin, begin.mark(), "a second document: put all into the first one");
  }
  return YAML::Load(text);
}

/// Turns a document into parameters, and ends where it is none: aliases may stand for any number of
/// values, and for themselves.
class DocumentReader {
 public:
  explicit DocumentReader(const std::string& origin) : origin_(origin) {}

  ParameterMap read(const YAML::Node& document) {
    readInto("", document, 0);
    return std::move(parameters_);
  }

 private:
  void readInto(const std::string& name, const YAML::Node& node, int depth) {
    if (!node.IsMap()) {
      parameters_[name] = valueOf(node, depth);
      return;
    }
    count(node, depth);
    for (const auto& member : node) {
      const std::string& key = member.first.Scalar();
      readInto(name.empty() ? key : name + "/" + key, member.second, depth + 1);
    }
  }

  XmlRpcValue valueOf(const YAML::Node& node, int depth) {
    count(node, depth);
    if (node.IsScalar()) return scalarFrom(node);
    if (!node.IsSequence()) return XmlRpcValue(std::string());  // a reader will name the parameter
    XmlRpcValue list;
    list.setSize(static_cast<int>(node.size()));
    for (std::size_t i = 0; i < node.size(); ++i) {
      list[static_cast<int>(i)] = valueOf(node[i], depth + 1);
    }
    return list;
  }

  void count(const YAML::Node& node, int depth) {
    constexpr int kMostValues = 10000;  // fifty times as many as the largest of config/
    constexpr int kDeepest = 20;
    if (++values_ <= kMostValues && depth <= kDeepest) return;
    throw errorAt(origin_, node.Mark(),
                  formatted("more than %d values or %d levels, aliases counted each time: this is "
                            "no parameter file",
                            kMostValues, kDeepest));
  }

  const std::string& origin_;
  ParameterMap parameters_;
  int values_ = 0;
};

std::string readText(const std::string& path) {
  constexpr std::size_t kMostBytes = 1U << 20U;  // a hundred times the largest of config/
  std::ifstream file(path);
  std::string text(kMostBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.empty()) throw std::runtime_error(path + ": cannot be read, or is empty");
  if (text.size() > kMostBytes) {
    throw std::runtime_error(path + ": more than 1 MB: this is no parameter file");
  }
  return text;
}

ParameterMap parametersFromFile(const std::string& path) {
  ParameterMap parameters = parametersFromYaml(readText(path), path);
  if (parameters.count("") != 0) {
    throw std::runtime_error(path + ": it is not a list of names and values");
  }
  return parameters;
}

}  // namespace

ParameterMap parametersFromYaml(const std::string& text, const std::string& origin) {
  try {
    return DocumentReader(origin).read(onlyDocument(text, origin));
  } catch (const YAML::Exception& error) {
    throw errorAt(origin, error.mark, error.msg);
  }
}

std::string packagedConfig(const std::string& file) {
  const std::string package = ros::package::getPath("bearing_calibration");
  if (package.empty()) {
    throw std::runtime_error("the package is not on ROS_PACKAGE_PATH: use rosrun");
  }
  return package + "/config/" + file;
}

ParameterMap parametersFromFiles(const std::vector<std::string>& files) {
  ParameterMap all;
  for (const std::string& file : files) {
    for (const auto& [name, value] : parametersFromFile(file)) all[name] = value;
  }
  return all;
}

void ParameterFiles::addNode(const std::string& node, const std::string& path) {
  nodes_[node] = parametersFromFile(path);
}

void ParameterFiles::overlay(const std::string& path) {
  for (const auto& [name, value] : parametersFromFile(path)) place(name, value, path);
}

void ParameterFiles::set(const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == 0 || equals == std::string::npos || equals + 1 == assignment.size()) {
    throw std::runtime_error("'" + assignment +
                             "' is not of the form NAME=VALUE, such as wheels/separation=0.40");
  }
  const std::string name = assignment.substr(0, equals);
  for (const auto& [below, value] : parametersFromYaml(assignment.substr(equals + 1), name)) {
    place(below.empty() ? name : name + "/" + below, value, "the command line");
  }
}

void ParameterFiles::place(const std::string& name, const XmlRpcValue& value,
                           const std::string& origin) {
  bool is_known = false;
  for (auto& [node, parameters] : nodes_) {
    const auto found = parameters.find(name);
    if (found == parameters.end()) continue;
    found->second = value;
    is_known = true;
  }
  if (!is_known) errors_.push_back("parameter " + name + " is not known (misspelt?): " + origin);
}

ParamReader ParameterFiles::reader(const std::string& node) const {
  ParamReader reader(nodes_.at(node));
  for (const std::string& error : errors_) reader.addError(error);
  return reader;
}

}  // namespace bearing_calibration_ros
