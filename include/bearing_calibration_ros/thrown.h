#pragma once

#include <XmlRpcException.h>

#include <exception>
#include <string>

namespace bearing_calibration_ros {

/// Does the work of a callback. Whatever it throws ends here: beyond its callback an exception
/// takes the manager and all its nodelets down.
/// @returns what was thrown, in words; empty when nothing was.
template <typename Work>
std::string thrownBy(Work work) {
  std::string words;
  try {
    work();
    return words;
  } catch (const std::exception& error) {
    words = error.what();
  } catch (const XmlRpc::XmlRpcException& error) {  // no std::exception
    words = error.getMessage();
  } catch (...) {
  }
  return words.empty() ? "an exception without words" : words;
}

}  // namespace bearing_calibration_ros
