#pragma once

#include <XmlRpcValue.h>

#include <string>
#include <vector>

namespace bearing_calibration_ros {

/// Parameters from YAML files, for programs that run without a master: what `rosparam load` of each
/// file in turn would put on the parameter server, so that a later file overrides single values of
/// an earlier one. deg(30) and rad(0.5) are read as roslaunch does.
/// @throws std::runtime_error which names the file (and line) that cannot be read.
XmlRpc::XmlRpcValue parametersFromFiles(const std::vector<std::string>& files);

}  // namespace bearing_calibration_ros
