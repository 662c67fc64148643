#pragma once

#include <XmlRpcValue.h>

#include <map>
#include <string>
#include <vector>

#include "bearing_calibration_ros/param_reader.h"

namespace bearing_calibration_ros {

/// What a YAML document says: deg(30) is an angle in radians, as in roslaunch, and 1e-6 a number,
/// which there is a string (it wants 1.0e-6). A value without a name has the name "".
/// @throws std::runtime_error with `origin` (a file's name) and line for what cannot be read.
ParameterMap parametersFromYaml(const std::string& text, const std::string& origin);

/// Path of a file in the package's folder config.
/// @throws std::runtime_error when the package is not on ROS_PACKAGE_PATH
std::string packagedConfig(const std::string& file);

/// What `rosparam load` of each file in turn would put on the parameter server, so that a later
/// file overrides single values of an earlier one.
/// @throws std::runtime_error which names the file (and line) that cannot be read.
ParameterMap parametersFromFiles(const std::vector<std::string>& files);

/// The parameters of one or several nodes for a program that has no parameter server: each node's
/// own file with all of them, and what differs on top, from files and from the command line. What
/// differs goes to every node that knows a parameter of that name.
class ParameterFiles {
 public:
  /// @param path of the file that holds all parameters of the node
  /// @throws std::runtime_error for a file that is no parameter file.
  void addNode(const std::string& node, const std::string& path);
  /// Takes over what a file says. @throws std::runtime_error as above.
  void overlay(const std::string& path);
  /// Takes over one value. @param assignment  such as "wheels/separation=0.40"
  /// @throws std::runtime_error when it has not that form.
  void set(const std::string& assignment);

  /// Names that no node knows become errors of the reader.
  ParamReader reader(const std::string& node) const;

 private:
  void place(const std::string& name, const XmlRpc::XmlRpcValue& value, const std::string& origin);

  std::map<std::string, ParameterMap> nodes_;
  std::vector<std::string> errors_;
};

}  // namespace bearing_calibration_ros
