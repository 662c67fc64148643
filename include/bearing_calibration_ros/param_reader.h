#pragma once

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace bearing_calibration_ros {

/// The value of a name such as "wheels/separation" in a tree of parameters; null when it has none.
XmlRpc::XmlRpcValue* findIn(XmlRpc::XmlRpcValue* tree, const std::string& name);

/// Names of all values in a tree that are no groups themselves.
std::vector<std::string> namesIn(XmlRpc::XmlRpcValue& tree);

/// Reads required parameters of one namespace (or of files: parameter_files.h) and collects every
/// error, so that a node can stop with all of them at once:
///
///     ParamReader params(private_node_handle);
///     config.wheel_separation_m = params.number("wheels/separation");
///     params.addErrors(config.validate());
///     params.throwIfAnyError();
///
/// A missing parameter, one of a wrong type, and one that nobody asked for in a group that was read
/// from (a misspelt name) are errors. There are no defaults here: they stand in config/*.yaml.
class ParamReader {
 public:
  explicit ParamReader(const ros::NodeHandle& node_handle);
  /// @param tree the parameters, groups in groups; none when it is not a group itself
  /// @param prefix stands before each name in errors
  ParamReader(const XmlRpc::XmlRpcValue& tree, const std::string& prefix);

  /// A finite number; an integer is taken as one. NaN on error.
  double number(const std::string& name);
  int integer(const std::string& name);
  bool boolean(const std::string& name);
  std::string text(const std::string& name);
  /// One of `choices`; returns its position, 0 on error.
  std::size_t choice(const std::string& name, const std::vector<std::string>& choices);
  /// A list of `count` finite numbers. That many NaN on error.
  std::vector<double> numbers(const std::string& name, std::size_t count);
  /// A list of lists of finite numbers, each of `row_size` (masks, polygons). Empty on error.
  std::vector<std::vector<double>> rows(const std::string& name, std::size_t row_size);

  void addError(const std::string& error) { errors_.push_back(error); }
  /// Sentences of a validation. One that names a parameter which could not be read is left out: it
  /// speaks of the placeholder that stands in for the value.
  void addErrors(const std::vector<std::string>& errors);
  const std::vector<std::string>& errors() const { return errors_; }
  /// What was read so far, as it would stand in a YAML file: by name.
  const std::map<std::string, std::string>& texts() const { return texts_; }

  /// Looks for misspelt names, then throws std::runtime_error with one line for each error.
  void throwIfAnyError();

 private:
  bool find(const std::string& name, XmlRpc::XmlRpcValue* value);
  void fail(const std::string& name, const std::string& why);
  void failKind(const std::string& name, const std::string& kind, XmlRpc::XmlRpcValue& value);
  void findUnknownNames();

  XmlRpc::XmlRpcValue tree_;
  std::string prefix_;
  std::map<std::string, std::string> texts_;
  std::set<std::string> names_;         ///< relative names asked for
  std::set<std::string> failed_names_;  ///< those of them that could not be read
  std::vector<std::string> errors_;
};

}  // namespace bearing_calibration_ros
