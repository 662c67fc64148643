#pragma once

#include <XmlRpcValue.h>
#include <ros/node_handle.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "bearing_calibration/common/parameters.h"
#include "bearing_calibration_ros/namespaces.h"

namespace bearing_calibration_ros {

/// Values by their whole names, such as "wheels/separation".
using ParameterMap = std::map<std::string, XmlRpc::XmlRpcValue>;

/// Reads what a configuration declares from one namespace (or from files: parameter_files.h), and
/// collects every error, so that a node can stop with all of them at once:
///
///     ParamReader params(private_node_handle);
///     config.declare(params);
///     params.throwIfAnyError();
///
/// A missing parameter, one of a wrong type, and one that nobody asked for in a group that was read
/// from (a misspelt name) are errors. There are no defaults here: they stand in config/*.yaml.
/// Numbers that only the robot's owner knows stand there as `required`, which is an error, too.
class ParamReader : public core::Parameters {
 public:
  explicit ParamReader(const ros::NodeHandle& node_handle);
  /// @param prefix stands before each name in errors
  explicit ParamReader(ParameterMap parameters, std::string prefix = "");

  /// A sentence about a parameter that could not be read is left out: it speaks of what stands in
  /// for the value. So is one that was said before.
  void addError(const std::string& sentence) override;
  std::vector<std::string> namesIn(const std::string& group) const override;
  void standIn(const std::string& name, double value) override { stand_ins_[name] = value; }
  /// What was read so far, as it would stand in a YAML file: by name.
  const std::map<std::string, std::string>& texts() const { return texts_; }

  /// Looks for misspelt names, then throws std::runtime_error with one line for each error.
  void throwIfAnyError();
  /// What throwIfAnyError() would say of the required numbers that are not given, which are no
  /// errors from now on: for a configuration that may turn out not to be needed. Empty when all are
  /// given.
  std::string takeRequired();

 private:
  /// Where it returns false, an error was added, and the value is as it was.
  bool readInto(const std::string& name, const Target& target) override;
  XmlRpc::XmlRpcValue* find(const std::string& name);
  bool fail(const std::string& name, const std::string& why);
  bool readRequired(const std::string& name, const Target& target);
  void findUnknownNames();

  ParameterMap parameters_;
  std::string prefix_;
  std::map<std::string, std::string> texts_;
  std::map<std::string, double> stand_ins_;
  std::vector<std::string> required_;   ///< sentences: numbers that are not given
  std::set<std::string> names_;         ///< relative names asked for
  std::set<std::string> failed_names_;  ///< those of them that could not be read
};

/// The configuration that parameters describe.
/// @throws std::runtime_error with one line for each that is missing, wrong or unknown.
template <typename Config>
Config readConfig(ParamReader params) {
  Config config;
  config.declare(params);
  params.throwIfAnyError();
  return config;
}

}  // namespace bearing_calibration_ros
